#!/usr/bin/env bash
# Records the hashes for tests/parity/same_bits.sh. Run it by hand after a deliberate change of the arithmetic (a new
# arithmetic_version, or before the first release) or of the scenes; no test runs it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
hashes=$(bash tests/parity/same_bits.sh --print)
{
  echo "# Recorded by tests/golden/update_goldens.sh: scene, hash of its tallies, hash of its pixels."
  echo "$hashes"
} >tests/golden/hashes.txt
git --no-pager diff --stat -- tests/golden/hashes.txt || true
echo "tests/golden/hashes.txt now holds the results of $(head -1 <<<"$hashes"). tests/parity/same_bits.sh says whether" \
  "every compiler agrees."
