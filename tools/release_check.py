"""Check that a version is ready to be tagged: docs/release.md has the check-list.

    release_check.py          in a clean checkout; prints what is missing, exit code 1

The tools for schemas and archives are installed in a temporary environment.
"""

import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Validate CITATION.cff and the recipe by their schemas; build, and check what an index would show.
TOOLS = ("cffconvert>=2", "py-rattler-build>=0.70", "build>=1", "twine>=6")
RECIPE = "tools/conda/recipe.yaml"


def version() -> str:
    """The version of the sources."""
    (found,) = re.findall(r'^__version__ = "(.+)"$', _text("plymotion/__init__.py"), re.M)
    return str(found)


def texts() -> Iterator[str]:
    """What the texts of a release lack."""
    expected = version()
    for name, pattern in (
        ("CITATION.cff", r"^version: (\S+)$"),
        (RECIPE, r'^  version: "(\S+)"$'),
        ("CHANGELOG.md", r"^## \[(\S+)\]"),
    ):
        found = re.findall(pattern, _text(name), re.M)[:1]
        if found != [expected]:
            yield f"{name}: version {found}, but plymotion/__init__.py has {expected}"
    if f"\n## [{expected}] - unreleased" in _text("CHANGELOG.md"):
        yield f"CHANGELOG.md: no date: write  ## [{expected}] - YYYY-MM-DD"
    project = tomllib.loads(_text("pyproject.toml"))["project"]
    if not project.get("urls"):
        yield (
            "pyproject.toml: no address of the repository: write below [project.scripts]\n"
            '    [project.urls]\n    Repository = "https://ADDRESS"'
        )
    recipe = _text(RECIPE)
    for requirement in project["dependencies"]:
        # conda has matplotlib without its windows as matplotlib-base
        name, bounds = re.split(r"(?=[>=<~!])", requirement.partition(";")[0], maxsplit=1)
        name = {"matplotlib": "matplotlib-base"}.get(name, name)
        if f"    - {name} {bounds}\n" not in recipe:
            yield f"{RECIPE}: {name} {bounds} is missing in requirements.run"
    if _run("git", "status", "--porcelain").stdout:
        yield "the checkout has changes that are not committed"


def archives(folder: Path) -> Iterator[str]:
    """What is wrong with schemas, sdist and wheel; `folder` is empty."""
    venv.create(folder / "tools", with_pip=True)
    python = str(folder / "tools/bin/python")
    installed = _run(python, "-m", "pip", "install", "--quiet", *TOOLS)
    if installed.returncode:
        yield f"tools cannot be installed:\n{installed.stderr}"
        return
    cite = "from cffconvert.cli.cli import cli; cli()"
    parse = "import sys, rattler_build as r; r.Stage0Recipe.from_yaml(open(sys.argv[1]).read())"
    for what, words in (
        ("CITATION.cff", ["-c", cite, "--validate", "-i", "CITATION.cff"]),
        (RECIPE, ["-c", parse, RECIPE]),
        ("sdist and wheel", ["-m", "build", "--outdir", str(folder / "dist")]),
    ):
        done = _run(python, *words)
        if done.returncode:
            yield f"{what}:\n{done.stdout}{done.stderr}"
    files = [str(path) for path in (folder / "dist").glob("plymotion-*")]
    done = _run(python, "-m", "twine", "check", "--strict", *files)
    if done.returncode:
        yield f"twine:\n{done.stdout}{done.stderr}"
    venv.create(folder / "new", with_pip=True)
    python = str(folder / "new/bin/python")
    _run(python, "-m", "pip", "install", "--quiet", *[f for f in files if f.endswith(".whl")])
    for words in (["--version"], ["new", "pendulum"], ["pendulum/case.toml", "--jobs", "1"]):
        done = _run(str(folder / "new/bin/plymotion"), *words, cwd=folder)
        if done.returncode:
            yield f"the wheel in a new environment, plymotion {' '.join(words)}:\n{done.stderr}"


def main() -> int:
    """Print what is missing."""
    missing = list(texts())
    with tempfile.TemporaryDirectory() as folder:
        missing += archives(Path(folder))
    print("\n".join(missing) or f"{version()} is ready to be tagged")
    return bool(missing)


def _text(name: str) -> str:
    return (ROOT / name).read_text("utf-8")


def _run(*words: str, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True)


if __name__ == "__main__":
    sys.exit(main())
