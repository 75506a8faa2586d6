#!/usr/bin/env bash
# Set up flexdyn in .venv and run the paper's study: the first of the README's two commands.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/setup.sh

make_venv all
.venv/bin/flexdyn paper -o flexdyn_paper

cat <<'TEXT'

Look at flexdyn_paper/summary.md and its figures. Then try:
  .venv/bin/flexdyn info scara_two_link
  .venv/bin/flexdyn simulate scara_two_link --duration 5 --q0 0,1 --v0 1,-2 -o run.h5
  .venv/bin/flexdyn play run.h5 --rigid
  .venv/bin/flexdyn plot run.h5
  .venv/bin/flexdyn new path/to/your.urdf -o model.yaml
TEXT
