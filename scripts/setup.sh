# Sourced by run.sh, test.sh and docs.sh: finds what the set-up needs, says what is missing, makes .venv.
# shellcheck shell=bash

fail() {
  printf 'flexdyn set-up: %s\n' "$1" >&2
  exit 2
}

find_python() {
  local candidate
  for candidate in "${PYTHON:-}" python3 python3.14 python3.13 python3.12 python3.11; do
    [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 || continue
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      printf '%s' "$candidate"
      return
    fi
  done
  fail "Python 3.11 or later is missing. Debian, Ubuntu: apt install python3 python3-venv. macOS: brew install python. Or name one: PYTHON=/path/to/python3 $0"
}

need_compiler() {
  local candidate
  for candidate in "${CXX:-}" c++ g++ clang++; do
    [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 && return
  done
  fail "a C++ compiler is missing (the core is compiled on installation). Debian, Ubuntu: apt install g++. Fedora: dnf install gcc-c++. macOS: xcode-select --install"
}

# make_venv EXTRA: .venv with flexdyn[EXTRA] built from this checkout; nothing to do where that is there already.
# FLEXDYN_WHEEL=flexdyn-....whl installs that wheel instead, which needs no compiler.
make_venv() {
  local python wheel=${FLEXDYN_WHEEL:-}
  python=$(find_python) || exit 2
  if [ -z "$wheel" ]; then
    need_compiler
  elif [ ! -f "$wheel" ]; then
    fail "there is no wheel $wheel (FLEXDYN_WHEEL): scripts/release.sh makes one"
  fi
  # Without pip, an earlier attempt was interrupted.
  if [ ! -x .venv/bin/python ] || [ ! -x .venv/bin/pip ]; then
    # uv, where there is one, makes the same in a tenth of the time.
    uv venv --quiet --clear --seed --python "$(command -v "$python")" .venv 2>/dev/null || "$python" -m venv .venv || {
      rm -rf .venv
      fail "python's venv module does not work. Debian, Ubuntu: apt install python3-venv"
    }
  fi
  .venv/bin/python scripts/install.py "$1" ${wheel:+"$wheel"} ||
    fail "the installation failed; the lines above say why. Behind a proxy or without a network, point pip at your package index"
}

# want_chromium: the browser that tests open pages in; installed where that needs no question, else they say why they skip.
want_chromium() {
  local candidate as_root=()
  for candidate in chromium chromium-browser google-chrome; do
    command -v "$candidate" >/dev/null 2>&1 && return
  done
  [ "$(id -u)" -eq 0 ] || as_root=(sudo -n)
  if command -v apt-get >/dev/null 2>&1 && "${as_root[@]}" true 2>/dev/null; then
    printf 'Installing chromium, in which the tests open the pages that flexdyn writes ...\n'
    "${as_root[@]}" apt-get update -qq || true # lists that are there already may do
    if "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends chromium >/dev/null; then
      return
    fi
  fi
  printf 'No chromium: the tests in the browser are skipped. Debian: apt install chromium. Fedora: dnf install chromium\n' >&2
}

# build_docs: the site, from the installed package, into build/docs.
build_docs() {
  PYTHONSAFEPATH=1 .venv/bin/python -m sphinx --fail-on-warning --keep-going --fresh-env --quiet docs build/docs
}
