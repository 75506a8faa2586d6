#!/usr/bin/env bash
# Set up .venv with the test extras and run everything that CI runs: the second of the README's two commands.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/setup.sh

want_chromium
make_venv test,docs
# Tests see the installed package, as a user does, and not the folder of the same name beside them.
export PYTHONSAFEPATH=1
# Libraries are installed without bytecode: where Python may not write it, every process compiles all that it imports.
unset PYTHONDONTWRITEBYTECODE
bin=.venv/bin
"$bin/ruff" check .
"$bin/ruff" format --check .
# Types take one processor for as long as the pages and the first tests take the other one.
"$bin/mypy" flexdyn tests scripts benchmarks &
types=$!
build_docs
# Tests wait a fifth of their time for processes, clocks and the browser: one worker more than there are processors.
# Tests of one file stay together, for they share what is dear to make.
workers=$("$bin/python" -c 'import os; print((os.cpu_count() or 1) + 1)')
# Threads of the linear algebra beside the workers would spend their time waiting for each other; tests that are about
# them set their own number.
export OPENBLAS_NUM_THREADS=1
"$bin/pytest" -n "$workers" --dist loadfile "$@"
wait "$types"
