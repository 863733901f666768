#!/bin/sh
# Install what runs need, or what tests need as well, into an environment that
# virtual_environment.sh has made: light_environment.sh FOLDER runs|tests
# LOCKED=1 (CI): exactly the wheels of tools/requirements.lock, checked by their hashes.
set -eu
folder=$1
what=$2
here=$(dirname "$0")

install() { "$here/install.sh" "$folder/bin/python" "$@"; }

if [ -n "${LOCKED:-}" ]; then
    # The one file has the wheels of the tests too; for runs they may have come without the lock.
    install --require-hashes --only-binary :all: -r "$here/requirements.lock"
    [ "$what" = tests ] || install --no-deps --no-build-isolation -e .
    echo "setup: $folder: ready for $what, as locked"
    exit
fi
if [ "$what" = tests ]; then
    install -e '.[test]'
    echo "setup: $folder: ready for tests"
    exit
fi
install -e '.[fatigue,blade,completion]'
echo "setup: $folder: ready for runs"
