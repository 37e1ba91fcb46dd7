#!/usr/bin/env bash
# Little memory, few threads, processes and file descriptors, small files, and SIGTERM at any moment: a render of a scene
# with an image of the sky ends with a picture, or with exit code 5, 6 or 143 and a message; never with a hang, an abort or
# a crash.
set -euo pipefail
program=${TYNDALL_BINARY:?}
[[ $("$program" --version) == *.exr* ]] || { echo "SKIPPED: built without OpenEXR"; exit 77; }
scratch=$(mktemp -d)
trap 'cd /; rm -rf "$scratch"' EXIT
chmod 755 "$scratch"
cd "$scratch"
cat >sky.json <<'JSON'
{"tyndall": 1,
 "medium": {"components": [{"field": {"type": "sphere", "radius": 0.4}, "extinction": 10, "albedo": 0.9}]},
 "lights": [{"type": "environment", "image": "sky.exr"}],
 "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "resolution": [32, 32]},
 "photons": {"count": 20000, "illumination": {"resolution": 8}}, "gather": {"samples": 8}}
JSON
"$program" render sky.json -o sky.exr -D 'lights=[{"type":"environment","radiance":1}]' -D camera.type=spherical \
  -D 'camera.resolution=[64,32]' 2>err || { cat err; exit 1; }
failed=0
# ends CODE WHAT: checks that a run with that exit code ended in an allowed way
ends() {
  local code=$1 what=$2
  # Before main() the dynamic loader reports errors.
  if ((code == 127)) && grep -q "error while loading shared libraries" err; then return; fi
  if [[ " 0 5 6 143 " != *" $code "* ]] || { ((code == 5 || code == 6)) && ! grep -q "^tyndall: " err; }; then
    echo "$what: exit code $code: $(tail -2 err)"
    failed=1
  fi
  if ((code == 5 || code == 6)) && [[ -n $(find . -name '.tyndall-*') ]]; then
    echo "$what: something is left behind"
    failed=1
  fi
}

for output in a.exr a.png a.pfm; do
  [[ $("$program" --version) == *${output#a}* ]] || continue
  for threads in 1 8; do
    for limit in 40000 60000 80000 100000 120000 140000 160000 180000 200000 240000 280000 330000 380000 400000 410000 \
      450000 550000 700000 900000 1300000 2000000; do
      code=0
      (ulimit -v $limit && exec timeout -k 2 30 "$program" render sky.json -t $threads -o $output) >out 2>err || code=$?
      ends $code "ulimit -v $limit, $threads threads, $output"
    done
  done
done

# Standard output stays empty, also if the reader's report finds no pipe.
for files in 4 5 6 7 8 9 10 12 14 16 20; do
  code=0
  (exec >out 2>err && ulimit -n $files && exec "$program" render sky.json -o n.exr) || code=$?
  ends $code "ulimit -n $files"
  if [[ -s out ]]; then
    echo "ulimit -n $files: standard output has $(head -c 80 out)"
    failed=1
  fi
  if ((code == 6)) && ! grep -q "ulimit -n" err; then
    echo "ulimit -n $files: the limit is not named: $(tail -1 err)"
    failed=1
  fi
done

# Limits of processes do not apply to root; on some machines the tests run as root.
as_user=()
if ((EUID == 0)); then
  as_user=(setpriv --reuid=65534 --regid=65534 --clear-groups)
  chmod 777 .
fi
if "${as_user[@]}" "$program" --version >/dev/null 2>&1; then
  for processes in 1 2 3 5 8; do
    code=0
    (ulimit -u $processes && exec timeout -k 2 30 "${as_user[@]}" "$program" render sky.json -t 8 -o u.exr) >out 2>err || code=$?
    ends $code "ulimit -u $processes"
  done
else
  echo "SKIPPED: limits of processes: nobody else may run the program here"
fi

for blocks in 0 1 4 40; do # of 1024 bytes; the image itself has 24 of them
  code=0
  (ulimit -f $blocks && exec timeout -k 2 30 "$program" render sky.json -D 'camera.resolution=[64,64]' \
    -o big.pfm) >out 2>/dev/null || code=$?
  ((code == 5)) || { echo "ulimit -f $blocks: exit code $code, not 5"; failed=1; }
  [[ ! -e big.pfm && -z $(find . -name '.tyndall-*') ]] || { echo "ulimit -f $blocks: something is left behind"; failed=1; }
done

for moment in 0.00 0.01 0.02 0.03 0.05 0.08 0.1 0.15 0.2 0.3 0.5 0.8; do
  for output in s.exr s.png; do
    "$program" render sky.json -D gather.samples=100000 -o $output >out 2>err &
    child=$!
    sleep $moment
    kill -TERM $child
    code=0
    wait $child || code=$?
    ((code == 143)) || { echo "SIGTERM after $moment s: exit code $code: $(tail -2 err)"; failed=1; }
  done
done
exit $failed
