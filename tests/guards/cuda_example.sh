#!/usr/bin/env bash
# The example of docs/library.md compiles for devices; it includes only headers of the core. Exits with 77 (skipped)
# without nvcc.
set -euo pipefail
cd "${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}"
PATH=$PATH:/usr/local/cuda/bin
if ! command -v nvcc >/dev/null; then
  echo "SKIPPED: no nvcc here"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
nvcc -std=c++20 --fmad=false --expt-relaxed-constexpr -diag-suppress=20012 -Werror=all-warnings -arch=sm_90 -I include \
  -c docs/example/free_paths.cu -o "$scratch/example.o"
