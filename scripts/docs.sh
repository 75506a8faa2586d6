#!/usr/bin/env bash
# Build the documentation's site into build/docs: examples are executed, a warning is an error.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/setup.sh

make_venv all,docs
build_docs
printf 'Open build/docs/index.html\n'
