#!/bin/sh
# Install what runs need, or what tests need as well, into an environment that
# virtual_environment.sh has made: light_environment.sh FOLDER runs|tests
# LOCKED=1 (CI): exactly the wheels of tools/requirements.lock, checked by their hashes.
set -eu
folder=$1
what=$2
here=$(dirname "$0")

# Python compiles a module when it is first imported. pip would compile all of them: 12 s of 15.
later=--no-compile
[ -z "${PYTHONDONTWRITEBYTECODE:-}" ] || later=

install() { "$folder/bin/python" -m pip --disable-pip-version-check install --quiet $later "$@"; }

log=$folder/install.log
if [ -n "${LOCKED:-}" ]; then
    if [ "$what" = runs ]; then # the one file has the wheels of the tests too
        install --require-hashes --only-binary :all: -r "$here/requirements.lock"
        install --no-deps --no-build-isolation -e .
    fi
    echo "setup: $folder: ready for $what, as locked"
    exit
fi
if [ "$what" = tests ]; then
    install -e '.[test]'
    echo "setup: $folder: ready for tests"
    exit
fi
extras=plot,fatigue,blade,completion
if install -e ".[fast,$extras]" 2>"$log"; then
    fast="with Numba"
elif grep -qiE 'numba|llvmlite' "$log"; then
    # The same source runs as plain NumPy, so an environment without Numba is
    # slower but complete.
    fast="without Numba, which could not be installed (see $log): the solver runs as plain NumPy"
    install -e ".[$extras]"
else
    cat "$log" >&2
    exit 1
fi
echo "setup: $folder: ready for runs, $fast"
