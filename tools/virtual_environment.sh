#!/bin/sh
# Create the virtual environment FOLDER, unless it works: virtual_environment.sh FOLDER
# Uses $PYTHON, or the first Python >= 3.11 that starts, can create virtual environments and was
# optimised by a profile when it was built (distributions do, pyenv does not unless told: commands
# and tests take 12 to 25 % more CPU time), or else the first that is not. A name on PATH is
# not sufficient: a pyenv shim may fail, and Debian's minimal python3 has no ensurepip.
set -eu
folder=$1
here=$(dirname "$0")

starts() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }
makes_environments() { starts "$1" && "$1" -c 'import ensurepip, venv' >/dev/null 2>&1; }
# Debian's configuration does not name the option that its builds have.
optimised() {
    makes_environments "$1" && "$1" -c 'import sys, sysconfig
built = sysconfig.get_config_var("CONFIG_ARGS") or ""
sys.exit(sys.base_prefix != "/usr" and "--enable-optimizations" not in built)'
}
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

# For tools/install.sh, which does without where this fails.
uv() {
    [ -x "$folder/bin/uv" ] && return
    lock=$folder/uv.lock
    sed -n '/^uv==/,/[^\\]$/p' "$here/requirements.lock" >"$lock"
    "$folder/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile \
        --require-hashes --only-binary :all: -r "$lock" || echo "setup: no uv: pip installs, slowly"
}

if [ -x "$folder/bin/python" ] && starts "$folder/bin/python" &&
    "$folder/bin/python" -c 'import pip' >/dev/null 2>&1; then
    uv
    exit
fi
if ! python=$(choose optimised || choose makes_environments); then
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
uv
