#!/usr/bin/env bash
# Outputs that cannot be written, or only in part, and too little memory: the exit code names the cause, the old file
# stays. Cases that need root or a mount are reported as skipped if that is impossible.
set -euo pipefail
program=${TYNDALL_BINARY:?}
scratch=$(mktemp -d)
trap 'umount small readonly 2>/dev/null || true; cd /; rm -rf "$scratch"' EXIT
cd "$scratch"
cat >scene.json <<'JSON'
{"tyndall": 1,
 "medium": {"components": [{"field": {"type": "sphere", "radius": 0.4}, "extinction": 10, "albedo": 0.9}]},
 "lights": [{"type": "point", "position": [1.5, 2, 0.5], "power": 100}],
 "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "resolution": [256, 256]},
 "photons": {"count": 20000, "illumination": {"resolution": 16}}, "gather": {"samples": 64}}
JSON
failed=0 skipped=0
# expect CODE TEXT ARGUMENT...
expect() {
  local code=0 expected=$1 text=$2
  shift 2
  timeout 60 "$program" render scene.json "$@" >out 2>err || code=$?
  if ((code != expected)) || ! grep -q -- "$text" err; then
    echo "render $*: exit code $code, not $expected, or without '$text': $(tail -3 err)"
    failed=1
  fi
}
expect 5 "No space left" --report /dev/full -o b.pfm # a device, written directly
[[ -s b.pfm ]] || { echo "the other output is lost"; failed=1; }

mkdir small readonly
if mount -t tmpfs -o size=128k tmpfs small 2>/dev/null; then
  echo old >small/a.pfm
  expect 5 "No space left" -o small/a.pfm
  [[ $(<small/a.pfm) == old && $(find small -type f | wc -l) == 1 ]] || { echo "a full disk: the old file is gone, or more is there"; failed=1; }
  # A checkpoint without room is a warning: the picture has another place.
  expect 0 "tries again later" -o a.pfm --checkpoint small/c.tyn --checkpoint-every 0
  expect 0 "stopped by --time-limit 1s" -o a.pfm --samples 1000000 --time-limit 1s --checkpoint c.tyn
  [[ -s c.tyn ]] || { echo "no checkpoint at the limit"; failed=1; }
  rm -f a.pfm
  expect 5 "small/c.tyn: cannot be written" -o a.pfm --samples 1000000 --time-limit 1s --checkpoint small/c.tyn
  [[ -s a.pfm ]] || { echo "a checkpoint without room costs the picture"; failed=1; }
  mount -t tmpfs -o ro tmpfs readonly
  expect 5 "Read-only file system" -o readonly/a.pfm
  expect 5 "Read-only file system" -o a.pfm --checkpoint readonly/c.tyn
else
  echo "SKIPPED: full and read-only file systems, which cannot be mounted here"
  skipped=77
fi
# A part with photons only: the light of all replicates.
(ulimit -v 400000 && expect 6 "the render needs" --photon-range 0:20000 -D photons.illumination.resolution=120 -o p.tyn
  ! grep -q "^hash" err || { echo "the photons were shot first"; failed=1; }; exit "$failed") || failed=1
(ulimit -v 400000 && expect 6 "the render needs" -D 'camera.resolution=[4096,4096]' -o a.pfm; exit "$failed") || failed=1
exit $((failed ? failed : skipped))
