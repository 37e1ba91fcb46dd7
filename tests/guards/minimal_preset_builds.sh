#!/usr/bin/env bash
# The minimal preset builds and runs with header-only packages. It is built at -O0, where the compiler folds no call of
# libm, so the guard against these calls checks it, too.
set -euo pipefail
source_dir=${TYNDALL_SOURCE_DIR:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cd "$source_dir"
cmake --preset minimal -B "$scratch" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS="-O0 -g0"
cmake --build "$scratch" -j2
"$scratch/tyndall" --version

if ldd "$scratch/tyndall" | grep -E 'OpenEXR|Imath|OpenImageIO|openvdb|tbb|fmt'; then
  echo "the minimal program needs the libraries above" >&2
  exit 1
fi
TYNDALL_BUILD_DIR=$scratch bash "$source_dir/tests/guards/no_libm.sh"
