#!/usr/bin/env bash
# Checks of the device code without a device. tests/long/gpu_check builds with only the packages of tests/long/gpu_pack,
# with warnings as errors, and stops before the first launch. The guard checks its build:
#  - the device computes the same as the host: its PTX has no double precision and no contracted or approximate operation,
#    and every sum and product has the suffix of rounding to nearest (ptxas may contract those without it);
#  - registers of each kernel are within cuda/registers.txt; no kernel has a stack or spills;
#  - the .cu files are small, without physics, and no kernel is empty.
#
#   cuda.sh [--record]      --record writes cuda/registers.txt
#
# Exits with 77 (skipped) without nvcc.
set -euo pipefail
cd "${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}"
PATH=$PATH:/usr/local/cuda/bin
if ! command -v nvcc >/dev/null; then
  echo "SKIPPED: no nvcc here"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# ---- a separate tree, as it would be copied to a machine with a GPU
tree=$scratch/tree
mkdir "$tree"
cp -r CMakeLists.txt CMakePresets.json bench cuda include packaging scenes src tests "$tree"
tests/long/gpu_pack "$tree/build/gpu_pack"
# Hides installed packages, if that is allowed.
hidden=(/usr/include/{glm,fmt,nlohmann,CLI,nanovdb,openvdb,Random123,gtest,gmock,tbb,OpenEXR,Imath,OpenImageIO}
  /usr/share/cmake /usr/lib/x86_64-linux-gnu/cmake /usr/src/googletest)
# shellcheck disable=SC2016  # expanded by the inner shells
hide='for folder in "$@"; do [[ ! -d $folder ]] || mount -t tmpfs none "$folder"; done'
if unshare -m bash -c "$hide" hide "${hidden[@]}" 2>/dev/null; then
  # shellcheck disable=SC2016
  covered=(unshare -m bash -c "$hide; "'exec "$tree/tests/long/gpu_check" --build' hide)
else
  echo "packages cannot be hidden here: gpu_check may find more than the packed ones"
  covered=("$tree/tests/long/gpu_check" --build)
  hidden=()
fi
export tree PATH CUDAFLAGS="-Xptxas=-v --no-compress"
export CCACHE_BASEDIR=$tree CCACHE_NOHASHDIR=1  # the folder has a new name each time
"${covered[@]}" "${hidden[@]}"
log=$tree/build/gpu_check/results/build.txt

# ---- strict arithmetic
# The Newton steps of inverse(), divide() and root() round as rcp.rn, div.rn and sqrt.rn do (tests/cuda compares them).
# They are skipped if they equal these instructions word by word; %f is any register.
cat >"$scratch/newton" <<'END'
.reg .f32 r, e; rcp.approx.ftz.f32 r, %f; fma.rn.f32 e, %f, r, 0fBF800000; neg.f32 e, e; fma.rn.f32 %f, r, e, r;
.reg .f32 n, r, e, q; rcp.approx.ftz.f32 r, %f; neg.f32 n, %f; fma.rn.f32 e, n, r, 0f3F800000; fma.rn.f32 r, r, e, r; mul.rn.f32 q, %f, r; fma.rn.f32 e, n, q, %f; fma.rn.f32 %f, r, e, q;
.reg .f32 r, n, e; rsqrt.approx.ftz.f32 r, %f; mul.rn.f32 %f, %f, r; mul.rn.f32 r, r, 0f3F000000; neg.f32 n, %f; fma.rn.f32 e, n, %f, %f; fma.rn.f32 %f, e, r, %f;
END
# read_out, a kernel of one line that runs once per replicate, is exempt: it uses double precision, as the host does.
# Writes one instruction per line, without predicate and operands: "mul.rn.f32".
strings -a -n 4 "$tree/build/gpu_check/src/libtyndall_cuda.a" | awk '
    NR == FNR { first = $0; sub(/;.*/, ";", first); known[$0] = 1; rest[first] = gsub(/;/, ";") - 1; next }
    { sub(/^[[:space:]]+/, "") }
    /^(\.[a-z]+ )*\.(entry|func) / { apart = /8read_out/ }
    apart { next }
    left { text = text " " $0; lines = lines "\n" $0
      if (--left == 0) { gsub(/%f[0-9]+/, "%f", text); if (text in known) ++left_out; else print lines }
      next }
    $0 in rest { left = rest[$0]; text = lines = $0; next }
    { print }
    END { print left_out + 0, "Newton steps of quotients and roots" >"/dev/stderr" }' "$scratch/newton" - \
  | sed -nE 's/^[[:space:]]*(@!?%p[0-9]+[[:space:]]+)?([a-z][a-z0-9_]*(\.[a-z0-9_:]+)+)[[:space:]].*/\2/p' \
    >"$scratch/instructions"
(($(grep -cE '^(add|mul|fma)\..*f32$' "$scratch/instructions") > 10000)) \
  || { echo "next to no arithmetic: nothing was checked" >&2; exit 1; }

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
# Conversions of signed and unsigned integers, 32 and 64 bits, to nearest: as on the host.
forbid '^cvt\.(r[zmp]|rna)\.f32\.[su]' "integers not rounded to nearest"
echo "$(grep -c 'f32$' "$scratch/instructions") single-precision instructions"

# ---- registers, stack, spills; small files
for file in cuda/*.cu* cuda/*.in; do
  if (($(wc -l <"$file") > 250)); then
    echo "$file has more than 250 lines: is there physics in it?"
    faults=1
  fi
done
python3 - "$log" "${1:-}" <<'PYTHON' || faults=1
import collections
import re
import subprocess
import sys

# For sm_90. Registers are allocated in units of 8.
log, record = open(sys.argv[1]).read(), sys.argv[2] == "--record"
kernels = {}
for name, properties in re.findall(r"Compiling entry function '(\w+)' for 'sm_\w+'\n((?:.*\n){3})", log):
    registers = int(re.search(r"Used (\d+) registers", properties)[1])
    stack, stores, loads = map(int, re.search(r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads",
                                              properties).groups())
    kernels[name] = (registers, stack + stores + loads)
plain = subprocess.run(["c++filt"], input="\n".join(kernels), capture_output=True, text=True, check=True).stdout
def short(name):
    name = name.replace("tyndall::", "").replace("(anonymous namespace)::", "")
    verb, of = re.search(r"(begin|run)_\w+<(.*)>\(", name).groups()
    return ("begin:" if verb == "begin" else "") + of.replace(" ", "")
# Kernels of the benchmark and the tests, and read_out, only have to compile.
kernels = {short(name): figures for name, figures in zip(plain.splitlines(), kernels.values())
           if not re.search(r"tyndall::(bench|test)::|read_out", name)}
if record:
    with open("cuda/registers.txt", "w") as out:
        print("# kernel, registers of a thread; sm_90, recorded by tests/guards/cuda.sh --record", file=out)
        for name, (registers, _) in sorted(kernels.items()):
            print(name, registers, file=out)
budget = dict(line.split() for line in open("cuda/registers.txt") if not line.startswith("#"))
bad = 0
def say(text):
    global bad
    bad += 1
    print(text)
for name in sorted(budget.keys() | kernels.keys()):
    if name not in kernels or name not in budget:
        say(f"{name}: {'not built' if name in budget else 'not in cuda/registers.txt'}")
        continue
    registers, memory = kernels[name]
    if registers > int(budget[name]) + 8:
        say(f"{name}: {registers} registers, {budget[name]} recorded")
    if memory:
        say(f"{name}: {memory} bytes of stack and spills")
# Every medium has the same kernels, and separate kernels to begin paths (else all kernels would need their registers).
of_medium = collections.defaultdict(set)
for name in kernels:
    if medium := re.search(r"SingleMedium<\w+>|MixedMedium", name):
        of_medium[medium[0]].add(name.replace(medium[0], "MEDIUM"))
every = set().union(*of_medium.values())
for medium, names in of_medium.items():
    if names != every:
        say(f"{medium} has no {', '.join(sorted(every - names))}")
for name in every:
    if re.match("(Shoot|Gather)Pass", name) and "begin:" + name not in every:
        say(f"{name} has no kernel that begins its paths")
if not kernels:
    say("no kernels: nothing was checked")
    sys.exit(1)
print(f"{len(kernels)} kernels, {min(k[0] for k in kernels.values())} to {max(k[0] for k in kernels.values())} registers")
sys.exit(bad > 0)
PYTHON
exit "$faults"
