#!/usr/bin/env bash
# Every micro-benchmark runs. The time is too short for meaningful results.
set -euo pipefail
micro=${TYNDALL_BUILD_DIR:?}/tyndall-micro
if [[ ! -x $micro ]]; then
  echo "SKIPPED: built without Google Benchmark"
  exit 77
fi
rows=$("$micro" --benchmark_min_time=0.001 --benchmark_format=json 2>/dev/null | grep -c '"run_type"')
((rows == $("$micro" --benchmark_list_tests | wc -l)))
echo "$rows micro-benchmarks run"
