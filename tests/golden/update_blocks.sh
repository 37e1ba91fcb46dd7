#!/usr/bin/env bash
# Records the pictures of paths for tests/statistical/accuracy_test.cpp, in minutes. Run it by hand after a deliberate
# change of their scenes (tests/support/accuracy.cpp); no test runs it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
cmake --build --preset release --target tyndall-tests-long test-volumes >/dev/null
pictures=$(TYNDALL_SOURCE_DIR=$PWD TYNDALL_TEST_VOLUMES=$PWD/build/release/tests/volumes \
  build/release/tests/tyndall-tests-long --record)
{
  echo "# Recorded by tests/golden/update_blocks.sh: medium, radiance [W/(area sr)] in the 16 blocks of a picture by paths."
  echo "$pictures"
} >tests/golden/blocks.txt
