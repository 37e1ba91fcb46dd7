#!/usr/bin/env bash
# Whatever becomes of the process that reads a volume, Tyndall ends with exit code 4, names the file and leaves nobody
# behind: in place of the reader stand programs that crash, hang, end without a word, or say too much or nonsense.
set -euo pipefail
program=${TYNDALL_BINARY:?}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp "$program" "$scratch/tyndall" # it looks for the reader beside itself
file=$scratch/smoke.vdb
echo "what it says does not matter" >"$file"
failed=0
# expect WORDS BODY: the reader is a shell script of that body
expect() {
  printf '#!/bin/sh\n%s\n' "$2" >"$scratch/tyndall-vdb"
  chmod +x "$scratch/tyndall-vdb"
  local start=$SECONDS code=0 message
  message=$("$scratch/tyndall" info "$file" 2>&1) || code=$?
  if ((code != 4 || SECONDS - start > 12)) || [[ $message != *"$file: "*"$1"* ]]; then
    echo "$2: exit code $code after $((SECONDS - start)) s: $message"
    failed=1
  fi
}
# shellcheck disable=SC2016 # $$ is the reader's
{
  expect "crashed (SIGSEGV); nothing else came to harm" 'kill -SEGV $$'
  expect "more memory than there is, and was ended" 'kill -KILL $$'
}
expect "failed without a word" 'exit 3'
expect "failed without a word" 'echo "{\"grids\": ["'
expect "no grid came back" 'echo "{\"grids\": [{\"unique_name\": \"density\", \"type\": \"float\"}], \"loaded\": {}}"'
expect "given up after" 'exec yes'
expect "given up after" 'exec sleep 98765'
if pgrep -f "^sleep 98765$" >/dev/null; then
  echo "a reader was left behind"
  failed=1
fi
exit "$failed"
