"""Pin the environment of CI: names, versions and hashes of all wheels, for some Python versions.

    python tools/lock.py 3.11 3.12 3.13

Writes tools/requirements.lock, which tools/light_environment.sh installs from with LOCKED=1 (CI).
Users get what the lower bounds in pyproject.toml allow. One file serves all versions of Python: a
package has a line for each of its versions, with a marker, and the hashes of this platform's
wheels.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCK = ROOT / "tools/requirements.lock"
EXTRAS = ("test",)  # as tools/light_environment.sh installs them
BUILD = ("editables",)  # hatchling asks for it when it installs a checkout

HEAD = """\
# Written by tools/lock.py: what CI installs. Names, versions and hashes only; no package is built.
"""

Package = tuple[str, str]  # name, version


def resolved(python: str, wanted: list[str]) -> dict[Package, str]:
    """Return the hash of the wheel of every package that pip would install."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed"]
        where = ["--target", folder, "--only-binary", ":all:", "--python-version", python]
        subprocess.run([*pip, *where, "--report", str(report), *wanted], check=True)
        return hashes(json.loads(report.read_text(encoding="utf-8")))


def hashes(report: dict) -> dict[Package, str]:
    """Return the hash of every package in a report of pip."""
    found = {}
    for entry in report["install"]:
        name, version = entry["metadata"]["name"], entry["metadata"]["version"]
        digest = entry["download_info"]["archive_info"]["hashes"]["sha256"]
        found[name.lower().replace("_", "-"), version] = digest
    return found


def lock(tables: dict[str, dict[Package, str]]) -> str:
    """Return the text of the lock file; `tables` has the packages of each version of Python."""
    pythons: dict[Package, dict[str, str]] = {}
    for python, table in tables.items():
        for package, digest in table.items():
            pythons.setdefault(package, {})[python] = digest
    lines = [HEAD]
    for (name, version), digests in sorted(pythons.items()):
        marker = ""
        if len(digests) < len(tables):
            which = " or ".join(f'python_version == "{python}"' for python in digests)
            marker = f" ; {which}"
        shown = "".join(f" \\\n    --hash=sha256:{d}" for d in dict.fromkeys(digests.values()))
        lines.append(f"{name}=={version}{marker}{shown}\n")
    return "".join(lines)


def wanted() -> list[str]:
    """Return what the environment of a checkout asks for."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = table["project"]
    extras = [r for extra in EXTRAS for r in project["optional-dependencies"][extra]]
    return [*project["dependencies"], *extras, *table["build-system"]["requires"], *BUILD]


def main() -> None:
    """Write the lock file for the versions of Python that are named, or for this one."""
    pythons = sys.argv[1:] or [f"{sys.version_info[0]}.{sys.version_info[1]}"]
    text = lock({python: resolved(python, wanted()) for python in pythons})
    part = LOCK.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(LOCK)


if __name__ == "__main__":
    main()
