#!/usr/bin/env bash
# Nothing that reaches a tally calls the C library's transcendental functions: their last bit depends on the library,
# and compilers fold them at -O2 and call them at -O0. sqrt, fma, floor and the like are exact and allowed.
#
#   no_libm.sh [BUILD FOLDER]
set -euo pipefail
build=${1:-${TYNDALL_BUILD_DIR:?}}

functions='a?(sin|cos|tan)h?|atan2|sincos|exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|powi|cbrt|hypot'
functions+='|erfc?|[lt]gamma|gamma|j[01n]|y[01n]'
pattern=" U (__)?($functions)[fl]?(_finite|_r)?(@.*)?\$"

for library in render host; do
  file=$build/src/libtyndall_$library.a
  symbols=$(nm -A "$file" 2>/dev/null)
  [[ $symbols == *" U "* ]] || { echo "$file: no symbols: nothing was checked" >&2; exit 1; }
  if grep -E "$pattern" <<<"$symbols"; then
    echo "$file calls libm (above): use the core's own functions" >&2
    exit 1
  fi
  echo "$file: no libm transcendental among $(grep -c ' U ' <<<"$symbols") undefined symbols"
done
