#!/bin/sh
# Create or update the light environment: light_environment.sh FOLDER
# Uses $PYTHON, or the first Python >= 3.11 that starts and can create
# virtual environments. A name on PATH is not sufficient: a pyenv shim may fail,
# and Debian's minimal python3 has no ensurepip.
# LOCKED=1 (CI): exactly the wheels of tools/requirements.lock, checked by their hashes.
set -eu
folder=$1
here=$(dirname "$0")

starts() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }
makes_environments() { starts "$1" && "$1" -c 'import ensurepip, venv' >/dev/null 2>&1; }
version() { "$1" -c 'import platform; print(platform.python_version())'; }

if [ -n "${PYTHON:-}" ]; then
    candidates=$PYTHON
else
    candidates="python3.13 python3.12 python3.11 python3 /usr/bin/python3"
fi

choose() {
    for name in $candidates; do
        if "$1" "$name"; then command -v "$name"; return; fi
    done
    return 1
}

if [ -x "$folder/bin/python" ] && starts "$folder/bin/python" &&
    "$folder/bin/python" -c 'import pip' >/dev/null 2>&1; then
    echo "setup: $folder: refreshing, Python $(version "$folder/bin/python")"
else
    if ! python=$(choose makes_environments); then
        if ! python=$(choose starts); then
            echo "setup: no Python >= 3.11 starts here (tried: $candidates)." >&2
            echo "setup: install one, or name it:  make PYTHON=/path/to/python3.12 ..." >&2
            exit 1
        fi
        echo "setup: $python has no ensurepip: installing python3-venv"
        "$here/apt_install.sh" python3-venv || true
        if ! makes_environments "$python"; then
            echo "setup: $python cannot make virtual environments: install its venv" \
                "package, or name another one:  make PYTHON=/path/to/python3.12 ..." >&2
            exit 1
        fi
    fi
    echo "setup: $folder: Python $(version "$python") ($python)"
    "$python" -m venv --clear "$folder"
fi

pip() { "$folder/bin/python" -m pip --disable-pip-version-check "$@"; }

log=$folder/install.log
if [ -n "${LOCKED:-}" ]; then
    pip install --quiet --require-hashes --only-binary :all: -r "$here/requirements.lock"
    pip install --quiet --no-deps --no-build-isolation -e .
    echo "setup: $folder: ready, as locked"
    exit
fi
if pip install --quiet -e '.[fast,plot,test]' 2>"$log"; then
    fast="with Numba"
elif grep -qiE 'numba|llvmlite' "$log"; then
    # The same source runs as plain NumPy, so an environment without Numba is
    # slower but complete.
    fast="without Numba, which could not be installed (see $log): the solver runs as plain NumPy"
    pip install --quiet -e '.[plot,test]'
else
    cat "$log" >&2
    exit 1
fi
echo "setup: $folder: ready, $fast"
