#!/usr/bin/env bash
# What is compiled for AVX-512 keeps to itself: an inline function of the core left out of line there could replace the
# plain one in the program, which would then fail on processors without.
set -euo pipefail
build=${TYNDALL_BUILD_DIR:?}
object=$(find "$build" -path '*tyndall_lanes_v4*' -name 'lane_stages*.o' | head -1)
if [[ -z $object ]]; then
  echo "SKIPPED: no stages for AVX-512 in this build"
  exit 77
fi
symbols=$(nm -C --defined-only "$object" | grep -E '^[0-9a-f]+ [A-Zu] ')
[[ -n $symbols ]] || { echo "$object: no symbols: nothing was checked" >&2; exit 1; }
if grep -v ' tyndall::v4::' <<<"$symbols"; then
  echo "$object defines the symbols above for the whole program" >&2
  exit 1
fi
echo "$object: $(wc -l <<<"$symbols") symbol, all of tyndall::v4"
