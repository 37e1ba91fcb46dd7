#!/usr/bin/env bash
# Every public header compiles alone, without a warning, with each installed compiler.
set -euo pipefail
cd "${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}/include"

compile() {
  echo "#include \"$2\"" | "$1" -x c++ -std=c++20 -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Werror \
    -fsyntax-only -I. - || { echo "$2 does not compile alone with $1" >&2; return 1; }
}
export -f compile

compilers=()
for compiler in g++ clang++; do
  if command -v "$compiler" >/dev/null; then compilers+=("$compiler"); else echo "not checked: no $compiler here"; fi
done
if ((${#compilers[@]} == 0)); then exit 77; fi

mapfile -t headers < <(find tyndall -name '*.h' | sort)
((${#headers[@]} > 0)) || { echo "no headers found" >&2; exit 1; }
for compiler in "${compilers[@]}"; do
  printf '%s\n' "${headers[@]}" | xargs -P2 -I{} bash -c 'compile "$@"' _ "$compiler" {}
  echo "${#headers[@]} headers compile alone with $compiler"
done
