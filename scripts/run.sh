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
  .venv/bin/flexdyn simulate panda --duration 1 -o run.csv
  .venv/bin/flexdyn new path/to/your.urdf -o model.yaml
TEXT
