"""Rules for every file of the repository."""

import re
import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest

# Folders that exist on one developer's machine only. Put together from pieces,
# since this file is looked at as well.
PRIVATE_PATH = re.compile(r"(?<![\w./$}-])/(?:work|home|root|Users|tmp)/[\w.]")
DOMAIN = r"\.(?:org|com|io|net|dev|cloud)\b"
REGISTRY_HOST = re.compile(
    r"\b(?:pypi|files\.pythonhosted|registry\.npmjs|deb\.debian|security\.debian|snapshot\.debian"
    r"|conda\.anaconda|repo\.anaconda|proxy\.golang|repo\.maven)"
    + DOMAIN
    + r"|\b[\w.-]*(?:artifact|artifactory|mirror)[\w-]*(?:\.[\w-]+)+"
    + DOMAIN
)
BINARY = {".png", ".vtkhdf", ".h5", ".pdf", ".gz", ".npz", ".stl"}


def tracked(repository: Path) -> list[Path]:
    """Files that are committed, or would be by `git add --all`."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(command, cwd=repository, capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip("not a git checkout")
    paths = sorted({repository / name for name in done.stdout.split("\0") if name})
    return [path for path in paths if path.is_file() and not path.is_symlink()]


def test_no_file_knows_the_machine_it_was_written_on(repository: Path) -> None:
    files = [path for path in tracked(repository) if path.suffix not in BINARY]
    assert len(files) > 20
    found = []
    for path in files:
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
            if PRIVATE_PATH.search(line) or REGISTRY_HOST.search(line):
                found.append(f"{path.relative_to(repository)}:{number}: {line.strip()[:100]}")
    assert not found, "\n".join(found)


def test_packages_and_pictures_know_no_machine(repository: Path) -> None:
    folders = [str(repository).encode(), str(Path.home()).encode() + b"/"]
    for path in tracked(repository):
        if path.suffix in BINARY:
            data = path.read_bytes()
            assert not any(folder in data for folder in folders), path


@pytest.mark.parametrize(
    "line",
    [
        "open('" + "/work" + "/main/x')",
        "see " + "/home" + "/ann/plymotion",
        "https://" + "pypi" + ".org/simple",
    ],
)
def test_the_rule_finds_them(line: str) -> None:
    assert PRIVATE_PATH.search(line) or REGISTRY_HOST.search(line)


@pytest.mark.parametrize("line", ["/usr/bin/python3", "/path/to/python3.12", "build/home/x"])
def test_the_rule_leaves_others_alone(line: str) -> None:
    assert not PRIVATE_PATH.search(line)
    assert not REGISTRY_HOST.search(line)


def test_no_symbolic_link_is_in_the_repository(repository: Path) -> None:
    """git on Windows writes a text file in the place of a link (docs/adr/0001)."""
    listed = subprocess.run(
        ["git", "ls-files", "--stage"], cwd=repository, capture_output=True, text=True, check=True
    )
    assert not [line for line in listed.stdout.splitlines() if line.startswith("120000")]


def test_a_checkout_offers_the_halves_and_nothing_else_that_lies_there() -> None:
    for half in ("solver", "preprocess"):
        found = find_spec(f"plymotion.{half}")
        assert found is not None
        assert Path(str(found.origin)).parent.name == half
    for other in ("tests", "cases", "tools", "plymotion", "meshes"):
        assert find_spec(f"plymotion.{other}") is None


def test_decisions_are_numbered_without_gaps(repository: Path) -> None:
    """Every number has a page, or stands in the row of those that became another page."""
    names = sorted(path.name for path in (repository / "docs" / "adr").glob("*.md"))
    index = (repository / "docs" / "README.md").read_text("utf-8")
    (moved,) = re.findall(r"^\| (\d{4}(?:, \d{4})*) \| Settings", index, re.MULTILINE)
    numbers = sorted([name[:4] for name in names] + moved.split(", "))
    assert numbers == [f"{n:04d}" for n in range(1, len(numbers) + 1)]
    for name in names:
        title = (repository / "docs" / "adr" / name).read_text("utf-8").splitlines()[0]
        assert re.match(rf"# {int(name[:4])}\. \S", title), f"{name}: first line is {title!r}"
