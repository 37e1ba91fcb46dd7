#!/usr/bin/env bash
# Device code computes what the host computes: its PTX has no double precision, no contracted or approximate operation,
# and says of every sum and product that it is rounded to nearest (ptxas may contract those that do not say so).
#
#   ptx_is_strict.sh [FILE.ptx]
#
# Ends with 77 (skipped) where there is no nvcc.
set -euo pipefail
cd "${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
ptx=${1:-$scratch/kernels.ptx}
if (($# == 0)); then
  nvcc=$(PATH=$PATH:/usr/local/cuda/bin command -v nvcc || true)
  if [[ -z $nvcc ]]; then
    echo "SKIPPED: no nvcc here"
    exit 77
  fi
  jobs=()
  for kernels in shoot gather measure; do
    "$nvcc" -std=c++20 -arch=sm_90 -O3 --fmad=false -Xcompiler=-ffp-contract=off --expt-relaxed-constexpr \
      -diag-suppress 20012 -Iinclude -ptx "cuda/$kernels.cu" -o "$scratch/$kernels.ptx.part" &
    jobs+=($!)
  done
  for job in "${jobs[@]}"; do wait "$job"; done
  cat "$scratch"/*.ptx.part >"$ptx"
fi

# One instruction a line, without its predicate and operands: "mul.rn.f32".
sed -nE 's/^[[:space:]]*(@!?%p[0-9]+[[:space:]]+)?([a-z][a-z0-9_]*(\.[a-z0-9_:]+)+)[[:space:]].*/\2/p' "$ptx" \
  >"$scratch/instructions"
(($(grep -cE '^(add|mul|fma)\..*f32$' "$scratch/instructions") > 100)) \
  || { echo "$ptx: next to no arithmetic: nothing was checked" >&2; exit 1; }

faults=0
forbid() {  # PATTERN WHY
  local found
  found=$(grep -E "$1" "$scratch/instructions" | sort | uniq -c | sort -rn || true)
  if [[ -n $found ]]; then
    printf 'forbidden in device code: %s\n%s\n' "$2" "$found"
    faults=1
  fi
}
forbid '\.(f64|f16|f16x2|bf16|bf16x2|tf32)(\.|$)' "arithmetic in another precision than single"
forbid '^(fma|mad)\..*f32' "contraction: a product and a sum rounded once"
forbid '\.(approx|full)(\.|$)' "approximate functions"
forbid '^(sin|cos|ex2|lg2|tanh|rsqrt)\.' "functions that only devices have"
forbid '\.(ftz|sat)(\.|$)' "denormals flushed to zero, or saturation"
forbid '^(add|sub|mul|div|rcp|sqrt)\.(r[zmp]\.)?f32$' "not rounded to nearest, or free to be contracted"
forbid '^(atom|red)\..*\.f(16|32|64)' "sums in floating point that depend on their order"
# Signed and unsigned, of 32 and 64 bits, to nearest: what the host does too.
forbid '^cvt\.(r[zmp]|rna)\.f32\.[su]' "integers not rounded to nearest"

if ((faults)); then exit 1; fi
echo "${ptx##*/}: $(grep -c 'f32$' "$scratch/instructions") single-precision instructions, all strict"
