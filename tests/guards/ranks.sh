#!/usr/bin/env bash
# Under mpirun: any number of ranks gives the same hash; a rank that dies ends the job, and its checkpoint resumes with
# another number of ranks to the same hash; an error is reported once. Exits with 77 (skipped) without MPI.
set -euo pipefail
program=${TYNDALL_BINARY:?}
if ! command -v mpirun >/dev/null || [[ ! -e $(dirname "$program")/tyndall_mpi.so ]]; then
  echo "SKIPPED: no MPI here"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none # which containers forbid, with many words
scene=${TYNDALL_SOURCE_DIR:?}/scenes/lonely_cloud.json
options=(-D 'camera.resolution=[64,48]' -D photons.illumination.resolution=24 --photons 400000 --samples 64)
cd "$scratch"
failed=0
complain() {
  echo "$*"
  failed=1
}
ranks() { # COUNT ARGUMENT...
  local count=$1
  shift
  timeout 120 mpirun -n "$count" "$program" render "$scene" "${options[@]}" "$@" 2>err
}

alone=$("$program" render "$scene" "${options[@]}" -o alone.pfm --print-hash 2>/dev/null)
for count in 1 2 3 4; do
  [[ $(ranks "$count" -o a.pfm --print-hash) == "$alone" ]] || complain "$count ranks: another hash: $(cat err)"
  cmp -s a.pfm alone.pfm || complain "$count ranks: another picture"
done

# A rank is killed once there is a checkpoint with photons.
for victim in 0 1; do
  rm -f c.tyn a.pfm
  ranks 3 -o "$scratch/a.pfm" --checkpoint c.tyn --checkpoint-every 0 &
  job=$!
  for ((i = 0; i < 500; ++i)); do
    [[ -e c.tyn ]] && "$program" info c.tyn 2>/dev/null | grep -q 'photons.*:[1-9]' && break
    sleep 0.02
  done
  mapfile -t pids < <(pgrep -f "^$program render .*$scratch/a.pfm" | sort -n)
  kill -KILL "${pids[victim]}"
  code=0
  wait "$job" || code=$?
  ((code != 0)) || complain "rank $victim was killed, and the job succeeded"
  [[ ! -e a.pfm ]] || complain "rank $victim was killed, and a picture was written"
  [[ -e c.tyn ]] || complain "rank $victim was killed, and there is no checkpoint"
  [[ $(ranks 2 -o a.pfm --checkpoint c.tyn --resume --print-hash) == "$alone" ]] \
    || complain "after rank $victim was killed: another hash: $(cat err)"
  grep -q 'resume .*: [1-9][0-9]* of' err || complain "after rank $victim was killed: nothing was kept: $(cat err)"
done

code=0
ranks 2 -D medium.extinction=1 || code=$?
((code == 3)) || complain "an invalid scene: exit code $code"
(($(grep -c 'medium.extinction' err) == 1)) || complain "an invalid scene is not reported once: $(cat err)"
code=0
ranks 3 --nonsense || code=$?
((code == 2)) || complain "a wrong option: exit code $code"
(($(grep -c 'nonsense' err) == 1)) || complain "a wrong option is not reported once: $(cat err)"
exit "$failed"
