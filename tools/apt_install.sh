#!/bin/sh
# Install Debian packages, or print instructions: apt_install.sh PACKAGE...
# Exit code 3: not possible here (no apt, or not root).
set -eu

if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup: this system has no apt-get; install with its own package manager: $*" >&2
    exit 3
fi
if [ "$(id -u)" -ne 0 ]; then
    echo "setup: not root; run this once:  sudo apt-get install --no-install-recommends $*" >&2
    exit 3
fi

export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Hundreds of lines that matter only when it fails.
quietly() { "$@" >"$log" 2>&1 || { tail -n 30 "$log" >&2; return 1; }; }
update() { echo "setup: apt-get update"; quietly apt-get update; }
install() {
    echo "setup: apt-get install $*"
    # Another apt at work, as on a machine that has just started, is waited for.
    quietly apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=300 "$@"
}

# A fresh machine has no package lists at all; an old one has lists that name
# versions which are gone: look again once before giving up.
if [ -z "$(find /var/lib/apt/lists -name '*_Packages*' 2>/dev/null | head -n 1)" ]; then
    update
    install "$@"
else
    install "$@" || { update && install "$@"; }
fi
