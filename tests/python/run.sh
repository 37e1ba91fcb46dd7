#!/usr/bin/env bash
# `pip install .` into an environment of its own, and the package's tests. Takes minutes, and the network for pip: part of
# tests/long/check_all, not of ctest.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install -q .
export TYNDALL_BINARY=${TYNDALL_BINARY:-$PWD/build/release/tyndall}
cd "$scratch"  # where no source can be imported by chance
"$scratch/venv/bin/python" "$OLDPWD/tests/python/test_tyndall.py"
