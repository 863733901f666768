#!/bin/sh
# What the tests of report.html need: browser.sh FOLDER
# A Chromium, from the distribution, and axe-core (checks of accessibility, MPL-2.0, 0.7 MB) from its
# package registry, in FOLDER/axe.min.js. What cannot be installed is left out; its tests are skipped.
set -eu
folder=$1
here=$(dirname "$0")
AXE=axe-core@4.14.1

mkdir -p "$folder"
if [ -z "${CHROMIUM:-}" ] && ! command -v chromium >/dev/null 2>&1 &&
    ! command -v chromium-browser >/dev/null 2>&1 && ! command -v google-chrome >/dev/null 2>&1; then
    "$here/apt_install.sh" chromium || echo "setup: no Chromium: tests of report.html in it are skipped"
fi
if command -v npm >/dev/null 2>&1 &&
    (cd "$folder" && npm pack --silent "$AXE" >/dev/null && tar -xzf axe-core-*.tgz &&
        mv package/axe.min.js axe.min.js && rm -rf package axe-core-*.tgz); then
    echo "setup: $folder/axe.min.js"
else
    echo "setup: no axe-core: the test of accessibility is skipped"
fi
