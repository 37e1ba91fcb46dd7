#!/usr/bin/env bash
# tyndall-bench reports errors before it times anything, and its outputs have the promised keys.
set -euo pipefail
bench=${TYNDALL_BUILD_DIR:?}/tyndall-bench
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# refuses CODE TEXT ARGUMENTS...
refuses() {
  local code=$1 text=$2 status=0
  shift 2
  timeout 20 "$bench" "$@" >"$folder/out" 2>"$folder/err" || status=$?
  if [[ $status != "$code" ]] || ! grep -qF -- "$text" "$folder/err" || grep -q photons/s "$folder/out"; then
    echo "tyndall-bench $*: exit $status instead of $code, or another message:" >&2
    cat "$folder/err" >&2
    exit 1
  fi
}
refuses 2 "--table" --table 4
refuses 2 "no row matches" --filter nothing
refuses 2 "no regular expression" --filter '('
refuses 2 "--repeats" --repeats 0
refuses 2 "--seconds" --seconds 0
refuses 2 "--seconds" --seconds nan
refuses 2 "--photons" --photons -1
if ! "$bench" --device cuda --list >"$folder/rows"; then
  refuses 7 "no CUDA" --device cuda
elif grep -vq '/tyndall$' "$folder/rows"; then
  echo "tyndall-bench --device cuda --list names rows of the CPU" >&2
  exit 1
fi
refuses 5 "$folder/none/rows.json" --filter 'LV/256.*/woodcock$' --json "$folder/none/rows.json"
refuses 5 "$folder" --filter 'LV/256.*/woodcock$' --html "$folder"

"$bench" --table 1 --filter 'LV/256.*/(super_voxel_2011|tyndall)$' --photons 2000 --repeats 1 \
  --json "$folder/rows.json" --html "$folder/page.html" >/dev/null
python3 - "$folder/rows.json" <<'END'
import json, sys
rows = json.load(open(sys.argv[1]))
keys = """table scene effective_resolution sampler device threads photons_per_second real_collisions_per_second
tentative_per_real lookups_per_real octaves_per_real cells_per_flight scatterings_per_photon""".split()
assert [r["sampler"] for r in rows] == ["super_voxel_2011", "tyndall"], rows
for row in rows:
    missing = [k for k in keys if k not in row]
    assert not missing, missing
END
python3 - "$folder/page.html" <<'END'
import re, sys, xml.dom.minidom
drawings = re.findall(r"<svg.*?</svg>", open(sys.argv[1]).read().replace("&sup3;", ""), re.S)
assert drawings
for drawing in drawings:
    xml.dom.minidom.parseString(drawing)
END
echo "refusals and rows are as promised"
