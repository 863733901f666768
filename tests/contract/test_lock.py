"""tools/requirements.lock: pinned, hashed, complete, and within the bounds of pyproject.toml."""

import re
import sys
import tomllib

import pytest
from packaging.requirements import Requirement

ENTRY = re.compile(
    r"(?P<name>[a-z0-9.-]+)==(?P<version>[^\s;]+)(?: ; [^\\]+)?"
    r"(?: \\\n    --hash=sha256:[0-9a-f]{64})+\n"
)


@pytest.fixture(scope="module")
def locked(repository):
    """Versions by name."""
    text = (repository / "tools/requirements.lock").read_text(encoding="utf-8")
    entries = "".join(line for line in text.splitlines(keepends=True) if line[0] != "#")
    found: dict[str, set[str]] = {}
    end = 0
    for entry in ENTRY.finditer(entries):
        assert entry.start() == end, entries[end : end + 100]  # nothing else: no address, no option
        found.setdefault(entry["name"], set()).add(entry["version"])
        end = entry.end()
    assert end == len(entries)
    return found


def test_all_that_is_asked_for_is_locked_within_its_bounds(repository, locked):
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for text in project["dependencies"] + extras["test"]:
        wanted = Requirement(text)
        assert str(wanted.specifier), f"{text}: users need a lower bound"
        assert locked[wanted.name.lower()], text
        assert all(wanted.specifier.contains(v) for v in locked[wanted.name.lower()]), text


def test_the_lock_of_reports(repository):
    """A package of one Python only has a marker; wheels of several have several hashes."""
    sys.path.insert(0, str(repository / "tools"))
    try:
        import lock
    finally:
        sys.path.pop(0)

    def report(*entries):
        return {
            "install": [
                {
                    "metadata": {"name": name, "version": version},
                    "download_info": {"archive_info": {"hashes": {"sha256": digest}}},
                }
                for name, version, digest in entries
            ]
        }

    tables = {
        "3.11": lock.hashes(report(("A_b", "1.0", "a1"), ("c", "2", "c2"), ("only", "1", "o"))),
        "3.12": lock.hashes(report(("a-b", "1.0", "a2"), ("c", "2", "c2"))),
    }
    assert lock.lock(tables).removeprefix(lock.HEAD) == (
        "a-b==1.0 \\\n    --hash=sha256:a1 \\\n    --hash=sha256:a2\n"
        "c==2 \\\n    --hash=sha256:c2\n"
        'only==1 ; python_version == "3.11" \\\n    --hash=sha256:o\n'
    )
