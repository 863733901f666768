#!/bin/sh
# Install packages for an interpreter: install.sh PYTHON ARGUMENT of `pip install` ...
# By uv, which takes a quarter of the CPU time of pip; by pip where uv is missing or fails. Neither
# compiles modules: Python does that when it first imports them, and most are never imported.
set -eu
python=$1
shift
own=$(dirname "$0")/../.venv/bin
if [ -x "$own/uv" ] && "$own/uv" pip install --quiet --python "$python" "$@"; then exit; fi
exec "$own/python" -m pip --disable-pip-version-check --python "$python" install --quiet \
    --no-compile "$@"
