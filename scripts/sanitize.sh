#!/usr/bin/env bash
# Build the core with one of GCC's or Clang's sanitizers and run its tests on that build (Linux, needs .venv of test.sh).
#
#   scripts/sanitize.sh address      memory: out of bounds, used after it was given back
#   scripts/sanitize.sh undefined    overflow of integers, bad shifts, null references, misaligned pointers
#   scripts/sanitize.sh thread       data races, with simulate_many and threads of Python
#   scripts/sanitize.sh all          address and undefined in one build, then thread: an hour on two cores
#
# More arguments go to pytest in place of the tests below. FLEXDYN_PYTHON: another Python than .venv/bin/python.
# FLEXDYN_BUILD: a folder that keeps the build for the next time. Exit code 1: something was found.
# Without more arguments the result goes to benchmarks/results/sanitizers.json.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/setup.sh

kind=${1:-}
[ $# -gt 0 ] && shift
if [ "$kind" = all ]; then
  failed=0
  for each in address,undefined thread; do
    (
      [ -z "${FLEXDYN_BUILD:-}" ] || export FLEXDYN_BUILD="$FLEXDYN_BUILD/${each%%,*}" # no comma: it parts options
      bash scripts/sanitize.sh "$each" "$@"
    ) || failed=1
  done
  exit "$failed"
fi
python=${FLEXDYN_PYTHON:-$PWD/.venv/bin/python}
threads=(tests/simulation/test_simulate_many.py tests/simulation/test_threads.py tests/batch/test_together.py
  tests/simulation/test_simulate_many_threads.py)
rows=(tests/diagnose/test_core_arrays.py tests/diagnose/test_rows.py tests/diagnose/test_innovations.py)
core=(tests/simulation tests/solvers tests/physics "${rows[@]}")
case $kind in
address | undefined | address,undefined) tests=("${core[@]}" tests/batch/test_together.py) ;;
thread) tests=("${threads[@]}" tests/solvers/test_together.py tests/simulation/test_users_laws.py "${rows[@]}") ;;
*) fail "say which sanitizer: $0 address, undefined, thread or all" ;;
esac
recorded=yes
[ $# -gt 0 ] && tests=("$@") && recorded=no
[ -x "$python" ] || fail "there is no $python: run scripts/test.sh first, or set FLEXDYN_PYTHON"
need_compiler

folder=${FLEXDYN_BUILD:-}
if [ -z "$folder" ]; then
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
fi
"$python" -m pip install . --quiet --no-deps --upgrade --target "$folder/flexdyn" \
  --config-settings=build-dir="$folder/build" --config-settings=cmake.build-type=Debug --config-settings=cmake.define.FLEXDYN_SANITIZE="$kind"

# The interpreter is not instrumented, so that the sanitizer's library has to be there before it.
compiler=${CXX:-c++}
library() { "$compiler" -print-file-name="$1"; }
case $kind in
address*)
  preload="$(library libasan.so):$(library libstdc++.so)"
  # Leaks are left out: CPython and NumPy keep what they allocated until the process ends.
  export ASAN_OPTIONS="detect_leaks=0:halt_on_error=1:abort_on_error=1:strict_init_order=1"
  export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1"
  ;;
undefined)
  preload=""
  export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1"
  ;;
thread)
  preload="$(library libtsan.so):$(library libstdc++.so)"
  export TSAN_OPTIONS="halt_on_error=0:exitcode=66:second_deadlock_stack=1"
  ;;
esac
# pytest keeps what tests write: findings go to files of their own.
rm -f "$folder"/found.* "$folder/tests.xml"
for options in ASAN_OPTIONS UBSAN_OPTIONS TSAN_OPTIONS; do
  [ -z "${!options:-}" ] || export "$options=${!options}:log_path=$folder/found"
done
export OPENBLAS_NUM_THREADS=1 PYTHONSAFEPATH=1 PYTHONPATH="$folder/flexdyn"
printf 'Running %s with the %s sanitizer ...\n' "${tests[*]}" "$kind"
# Memory that is watched is not given back, and what is counted beside a run counts slower.
left_out="not memory_is_given_back and not runs_beside and not nothing_is_left_at_exit"
# This sanitizer holds signals back while a thread computes.
[ "$kind" != thread ] || left_out+=" and not ctrl_c"
failed=0
LD_PRELOAD=$preload "$python" -m pytest -q -p no:cacheprovider --junitxml="$folder/tests.xml" -k "$left_out" "${tests[@]}" || failed=1
findings=0
for found in "$folder"/found.*; do
  [ -e "$found" ] || continue
  cat "$found"
  findings=$((findings + 1))
  failed=1
done
# A run that ended early has no report, and is not recorded.
if [ "$recorded" = yes ] && [ -f "$folder/tests.xml" ]; then
  "$python" scripts/sanitizer_result.py "$kind" "$folder/tests.xml" --findings "$findings" \
    -o benchmarks/results/sanitizers.json
fi
exit "$failed"
