#!/usr/bin/env bash
# If the process that reads a volume or an image fails in any way, Tyndall exits with 4 (6 if the process is killed, as
# for lack of memory), names the file and leaves no process behind. The guard replaces the reader by programs that crash,
# hang, exit silently, or write too much or nonsense.
set -euo pipefail
program=${TYNDALL_BINARY:?}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp "$program" "$scratch/tyndall" # it looks for the reader beside itself
failed=0
# expect_of FILE CODE WORDS BODY: uses a shell script with that body as the reader
expect_of() {
  local file=$scratch/$1
  echo "what it says does not matter" >"$file"
  for reader in tyndall-vdb tyndall-image; do
    printf '#!/bin/sh\n%s\n' "$4" >"$scratch/$reader"
    chmod +x "$scratch/$reader"
  done
  local start=$SECONDS code=0 message
  message=$("$scratch/tyndall" info "$file" 2>&1) || code=$?
  if ((code != $2 || SECONDS - start > 12)) || [[ $message != *"$file: "*"$3"* ]]; then
    echo "$1: $4: exit code $code after $((SECONDS - start)) s: $message"
    failed=1
  fi
}
expect() { expect_of smoke.vdb 4 "$@"; }
# shellcheck disable=SC2016 # $$ is the reader's
{
  expect "crashed (SIGSEGV); the renderer itself is unaffected" 'kill -SEGV $$'
  expect_of smoke.vdb 6 "was killed; the system does this when memory runs out" 'kill -KILL $$'
  expect_of sky.exr 4 "crashed (SIGABRT); the renderer itself is unaffected" 'kill -ABRT $$'
}
expect "failed without a message" 'exit 3'
expect "failed without a message" 'echo "{\"grids\": ["'
expect "reading it returned no grid" 'echo "{\"grids\": [{\"unique_name\": \"density\", \"type\": \"float\"}], \"loaded\": {}}"'
expect_of sky.exr 4 "failed without a message" 'exit 3'
expect_of sky.exr 4 "reading it returned no image" 'echo "{\"image\": {\"width\": 2, \"height\": 1}}"'
expect_of sky.exr 4 "reading it returned no image" 'echo "{\"image\": {\"width\": -2, \"height\": -1}}"'
expect "given up after" 'exec yes'
expect "given up after" 'exec sleep 98765'
if pgrep -f "^sleep 98765$" >/dev/null; then
  echo "a reader was left behind"
  failed=1
fi
exit "$failed"
