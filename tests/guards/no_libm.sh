#!/usr/bin/env bash
# Nothing that reaches a tally calls the C library's transcendental functions: their last bit depends on the library,
# and compilers fold them at -O2 and call them at -O0. sqrt, fma, floor and the like are exact and allowed.
#
#   no_libm.sh [FILE...]      objects or libraries; else those of the core in TYNDALL_BUILD_DIR
set -euo pipefail
files=("$@")
if (($# == 0)); then
  build=${TYNDALL_BUILD_DIR:?}
  files=("$build/src/libtyndall_render.a" "$build/src/libtyndall_host.a")
fi

functions='a?(sin|cos|tan)h?|atan2|sincos|exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|powi|cbrt|hypot'
functions+='|erfc?|[lt]gamma|gamma|j[01n]|y[01n]'
pattern=" U (__)?($functions)[fl]?(_finite|_r)?(@.*)?\$"

symbols=$(nm -A "${files[@]}" 2>/dev/null)
[[ $symbols == *" U "* ]] || { echo "${files[*]}: no symbols: nothing was checked" >&2; exit 1; }
if grep -E "$pattern" <<<"$symbols"; then
  echo "the core calls libm (above): use its own functions" >&2
  exit 1
fi
echo "no libm transcendental among $(grep -c ' U ' <<<"$symbols") undefined symbols of ${#files[@]} files"
