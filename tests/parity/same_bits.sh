#!/usr/bin/env bash
# A seed gives the same result, bit for bit, with every compiler: tests/parity/hashes.cpp, built by several compilers at
# several levels of optimisation and for several processors, prints the hashes in tests/golden/hashes.txt, also with any
# number of threads, any batch size and another rounding mode of the caller.
#
#   same_bits.sh [--all | --print]
#
# Four variants: g++ -O0 and -O2 (AVX2), clang++ -O2 (AVX2), and arm64 in an emulator. --all adds four: each installed
# compiler also at -O0 or -O2 for any x86-64, and at -O3 for this processor. --print prints the hashes of g++ -O2 and
# compares nothing.
#
# CXX replaces g++ or clang++, depending on its kind. Exits with 77 (skipped) if nothing could be compared.
set -euo pipefail
cd "${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}"
goldens=tests/golden/hashes.txt
scratch=$(mktemp -d)
trap 'jobs -pr | xargs -r kill; rm -rf "$scratch"' EXIT

gnu=g++ clang=clang++
if [[ -n ${CXX:-} ]]; then
  if "$CXX" --version | grep -q clang; then clang=$CXX; else gnu=$CXX; fi
fi
launcher=()
if command -v ccache >/dev/null; then
  launcher=(ccache)
  # The meaning of -march=native is part of the cache key.
  grep -m1 -E '^(flags|Features)' /proc/cpuinfo >"$scratch/processor" || true
  export CCACHE_EXTRAFILES=$scratch/processor
fi

# build NAME COMPILER FLAG...: builds $scratch/NAME/hashes, without TBB and with header-only packages.
build() {
  local name=$1 compiler=$2 source object objects=()
  shift 2
  mkdir "$scratch/$name"
  for source in src/scene/*.cpp src/render/*.cpp src/host/*.cpp tests/parity/hashes.cpp; do
    object=$scratch/$name/${source//\//_}.o
    "${launcher[@]}" "$compiler" -std=c++20 -ffp-contract=off "$@" -DFMT_HEADER_ONLY -Iinclude -Isrc \
      -c "$source" -o "$object" || return 1
    objects+=("$object")
  done
  # At -O0 the compiler folds no call of the C library's functions. The last object is the test's own.
  if [[ $name == gnu-O0 ]]; then bash tests/guards/no_libm.sh "${objects[@]::${#objects[@]}-1}" >&2 || return 1; fi
  "$compiler" "$@" "${objects[@]}" -pthread -o "$scratch/$name/hashes"
}

every='' print=''
case ${1:-} in
  "") ;;
  --all) every=1 ;;
  --print) print=1 ;;
  *) echo "usage: same_bits.sh [--all | --print]" >&2; exit 2 ;;
esac
if [[ $print ]]; then
  build print "$gnu" -O2 -DNDEBUG
  "$scratch/print/hashes"
  exit
fi

# compare RUN FILE: prints which scenes of FILE differ from the goldens, and how.
compare() {
  awk -v run="$1" '
    /^#/ { next }
    NR == FNR { golden[$1] = $0; next }
    { seen[$1] = 1 }
    golden[$1] != $0 {
      split(golden[$1], expected)
      what = expected[2] == $2 ? "pixels differ" : (expected[3] == $3 ? "tallies differ" : "tallies and pixels differ")
      printf "DIFFERS: %s: %s: %s: got %s %s, expected %s %s\n", run, $1, what, $2, $3, expected[2], expected[3]
      bad = 1
    }
    END {
      for (scene in golden) if (!(scene in seen)) { printf "DIFFERS: %s: %s is missing\n", run, scene; bad = 1 }
      exit bad
    }' "$goldens" "$2"
}

# check NAME RUNNER COMPILER FLAG...: checks one variant; lists its runs in NAME.passed and NAME.failed.
check() {
  local name=$1 runner=$2 options out runs=("--threads 2" "--threads 7 --batch 1000 --hostile")
  shift 2
  if [[ $name == gnu-O2-v3 ]]; then runs+=("--threads 1" "--threads 7" "--threads 1 --batch 37"); fi
  if ! build "$name" "$@" 2>"$scratch/$name.errors"; then
    echo "$name does not build:"
    grep -m5 -E 'error|not found|undefined' "$scratch/$name.errors" || tail -5 "$scratch/$name.errors"
    echo build >>"$scratch/$name.failed"
    return
  fi
  out=$scratch/$name/out
  for options in "${runs[@]}"; do
    # shellcheck disable=SC2086  # several words each
    if $runner "$scratch/$name/hashes" $options >"$out" && compare "$name $options" "$out"; then
      echo "$options" >>"$scratch/$name.passed"
    else
      echo "$options" >>"$scratch/$name.failed"
    fi
  done
}

names=()
skipped=0
skip() {
  echo "SKIPPED: $1: $2"
  skipped=$((skipped + 1))
}

# variant NAME RUNNER COMPILER FLAG...: starts its check, two at a time, or prints why it is skipped.
variant() {
  if ! command -v "$3" >/dev/null; then
    skip "$1" "no $3 here"
    return
  fi
  while (($(jobs -pr | wc -l) >= 2)); do wait -n || true; done
  names+=("$1")
  check "$@" >"$scratch/$1.log" 2>&1 &
}

host=$(uname -m)
if [[ $host != aarch64 ]]; then
  qemu=$(command -v qemu-aarch64 || command -v qemu-aarch64-static || true)
  if [[ -n $qemu ]]; then
    variant arm64 "$qemu" aarch64-linux-gnu-g++ -O2 -DNDEBUG -static
  else
    skip arm64 "no qemu-aarch64 here"
  fi
fi
if [[ $host == x86_64 ]]; then
  if grep -qw avx2 /proc/cpuinfo && grep -qw fma /proc/cpuinfo && grep -qw bmi2 /proc/cpuinfo; then
    variant gnu-O2-v3 "" "$gnu" -O2 -DNDEBUG -march=x86-64-v3
    variant clang-O2-v3 "" "$clang" -O2 -DNDEBUG -march=x86-64-v3
  else
    skip gnu-O2-v3 "this processor is no x86-64-v3"
    skip clang-O2-v3 "this processor is no x86-64-v3"
  fi
  if [[ $every ]]; then
    variant gnu-native "" "$gnu" -O3 -DNDEBUG -march=native
    variant clang-native "" "$clang" -O3 -DNDEBUG -march=native
  fi
else # no processor that the variants above are for
  variant clang-O2 "" "$clang" -O2 -DNDEBUG
fi
if [[ $every || $host != x86_64 ]]; then variant gnu-O2 "" "$gnu" -O2 -DNDEBUG; fi
if [[ $every ]]; then variant clang-O0 "" "$clang" -O0; fi
variant gnu-O0 "" "$gnu" -O0
wait

passed=0 failed=0
count() { if [[ -e $1 ]]; then wc -l <"$1"; else echo 0; fi; }
for name in "${names[@]}"; do
  good=$(count "$scratch/$name.passed") bad=$(count "$scratch/$name.failed")
  cat "$scratch/$name.log"
  echo "$name: $good runs agree, $bad do not"
  passed=$((passed + good)) failed=$((failed + bad))
done
echo "${#names[@]} variants, $passed runs agree with $goldens, $failed do not; $skipped variants skipped"
if ((failed > 0)); then
  echo "If all variants differ alike, the arithmetic changed: if that was intended, raise arithmetic_version and run"
  echo "tests/golden/update_goldens.sh. If only some differ, results depend on the compiler: find the reason."
  exit 1
fi
if ((passed == 0)); then exit 77; fi
