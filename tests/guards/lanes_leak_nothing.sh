#!/usr/bin/env bash
# Objects compiled for AVX2 and AVX-512 export no inline function of the core: the linker could use it in the whole
# program, which would then fail on processors without these instructions.
set -euo pipefail
build=${TYNDALL_BUILD_DIR:?}
checked=0
for isa in v3 v4; do
  object=$(find "$build" -path "*tyndall_lanes_$isa*" -name 'lane_stages*.o' | head -1)
  [[ -n $object ]] || continue
  symbols=$(nm -C --defined-only "$object" | grep -E '^[0-9a-f]+ [A-Zu] ')
  [[ -n $symbols ]] || { echo "$object: no symbols: nothing was checked" >&2; exit 1; }
  if grep -v " tyndall::$isa::" <<<"$symbols"; then
    echo "$object defines the symbols above for the whole program" >&2
    exit 1
  fi
  echo "$object: $(wc -l <<<"$symbols") symbol, all of tyndall::$isa"
  checked=$((checked + 1))
done
if [[ $checked == 0 ]]; then
  echo "SKIPPED: no stages for AVX2 or AVX-512 in this build"
  exit 77
fi
