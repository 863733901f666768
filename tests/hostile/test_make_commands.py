"""Names in a case file run no command and keep make from nothing."""

import shutil
import tomllib
from pathlib import Path

import pytest
from harness.make_samples import Project
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import checked_case

SHIPPED = "tests/packages/double-pendulum"
DONE = "build/one/report.html: up to date\n"
NAMES = {
    "make function": "$(shell touch P)",
    "make variable": "$(MAKE)${PY}$@$",
    "backquotes": "`touch P`",
    "shell": "'$$(touch P)'\"",
    "command": "x; touch P",
    "space": "two  words",
    "comment": "a#b",
    "pattern": "a%b%",
    "colon": "a:b::c",
    "backslash": "a\\ b\\",
    "others": "a|b=c&d(e)<f>~!*?[g]{h}",
    "assignment": "x := $(shell touch P)",
    "accents": "\u00e9\u4e2d",
    "a target": "FORCE",
}
GROUND = "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
DRIVEN = """
[joints.hinge{k}]
kind = "revolute"
between = ["ground.O", "b{k}.c"]
axis = [0.0, 0.0, 1.0]
drive = {{ table = {{ file = {table} }} }}
"""
SECTION = """
[sections.strip{k}]
file = {file}
[bodies.arm{k}]
kind = "beam"
length = 0.5
section = "strip{k}"
modes = [{{ kind = "bending-xy", count = 1 }}]
interfaces = {{ root = {{ at = "start" }} }}
"""
SHELL = """
[bodies.plate{k}]
kind = "shell"
shell = {file}
modes = [{{ kind = "lowest", count = 1 }}]
interfaces = {{ root = {{ at = "root" }} }}
"""


def _quoted(text: str) -> str:
    return "'''" + text + "'''"


def _ball(more: str) -> str:
    ball = rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
    return (
        HEAD
        + ball
        + SOLVER.format(t_end=0.02, step=0.01, more="").replace("[solver]", f"{more}\n[solver]")
    )


@pytest.fixture
def project(repository: Path, tmp_path: Path) -> Project:
    """A project with its own cases."""
    return Project(repository, tmp_path / "project")


def _no_command_ran(project: Project) -> None:
    assert not list(project.folder.rglob("P"))


def test_files_of_a_case_are_no_commands(project):
    """All names in one case; a change of any file is a change of the case.

    Make passes on the folder of the case alone, so its command is told of each file directly.
    """
    driven = "".join(
        rigid(f"b{k}", 1.0, 0.1, {"c": (0, 0, 0)})
        + DRIVEN.format(k=k, table=_quoted(name + ".csv"))
        for k, name in enumerate(NAMES.values())
    )
    folder = project.case("one", _ball(GROUND + driven))
    for name in NAMES.values():
        (folder / (name + ".csv")).write_text("0, 0\n1, 1\n")
    assert project.make("-n", "one").returncode == 0
    first = project.make("one")
    assert first.returncode == 0, first.stdout
    assert "base: done" in first.stdout
    assert project.make("one").stdout == DONE
    for name in NAMES.values():
        (folder / (name + ".csv")).touch()
        assert "base: up to date" in project.again("one"), name  # by content
        assert project.again("one") == DONE
    for name in NAMES.values():
        (folder / (name + ".csv")).touch()
    assert "base: up to date" in project.make("one").stdout
    (folder / (name + ".csv")).write_text("0, 0\n1, 2\n")
    assert "base: done" in project.make("one").stdout
    assert project.make("one").stdout == DONE
    _no_command_ran(project)


def test_packages_of_a_case_are_no_commands(project, repository):
    names = [NAMES[n] + ".vtkhdf" for n in ("make function", "command", "space", "others")]
    names.append("../../clean")  # a file in the folder of make, where a target has this name
    packages = "".join(
        f'[bodies.arm{k}]\nkind = "package"\npackage = {_quoted(name)}\n'
        for k, name in enumerate(names)
    )
    folder = project.case("one", _ball(packages))
    missing = project.make("one")
    assert missing.returncode != 0
    assert "no such file" in missing.stdout
    for name in names:
        shutil.copy(next((repository / SHIPPED).glob("*.vtkhdf")), folder / name)
    assert "base: done" in project.make("one").stdout
    assert project.make("one").stdout == DONE
    (folder / names[0]).touch()
    assert "base: up to date" in project.again("one")
    assert project.again("one") == DONE
    _no_command_ran(project)


def test_descriptions_of_a_case_are_no_commands(project, repository):
    """Packages need FEniCSx, which is not there: the command ends after the check."""
    names = [NAMES[n] + ".toml" for n in ("make function", "command", "space")]
    text = ""
    sources = {SECTION: "sections/box-layup-1", SHELL: "shells/plate-cantilever"}
    for form, source in sources.items():
        described = (repository / f"cases/{source}.toml").read_text()
        described = described.replace('"../../meshes/', f'"{repository}/meshes/')
        for name in names:
            file = f"{source[:5]} {name}"
            text += form.format(k=names.index(name), file=_quoted(file))
            project.case("one", described, file)
    project.case("one", _ball(text))
    assert project.make("-n", "one").returncode == 0
    told = project.make("one", "FENICSX_PYTHON=/nowhere")
    assert told.returncode != 0
    assert "FENICSX_PYTHON = /nowhere: cannot use FEniCSx" in told.stdout
    assert len(list((project.folder / "build/one/bodies").glob("*.json"))) == 2 * len(names)
    _no_command_ran(project)


CONTROLS = ["a\\nb", "a\\rb", "a\\u0000b", "a\\u001bb", "a\\u0085b"]
UNUSABLE = [(name, key) for key in ("package", "table", "section", "shell") for name in CONTROLS]


@pytest.mark.parametrize(("name", "key"), [*UNUSABLE, ("x" * 300, "shell")])
def test_paths_that_no_file_has_are_refused_with_words(tmp_path, capsys, name, key):
    path = f'"{name}"'
    text, named = {
        "package": (f'[bodies.x]\nkind = "package"\npackage = {path}\n', "bodies.x.package"),
        "table": (GROUND + DRIVEN.format(k="", table=path), "joints.hinge.drive.table.file"),
        "section": (SECTION.format(k="", file=path), "sections.strip.file"),
        "shell": (SHELL.format(k="", file=path), "bodies.plate.shell"),
    }[key]
    file = tmp_path / "case.toml"
    file.write_text(_ball(text))
    assert main(["check", str(file), "--out", str(tmp_path / "o")]) == 2
    told = capsys.readouterr().err
    assert f"{file}: {named} = " in told
    words = "at most 1000" if len(name) > 255 else "a path without control"
    assert f"expected {words} characters" in told
    assert all(ord(letter) >= 32 for letter in told.replace("\n", ""))
    assert len(told.splitlines()) == 1, told
    assert not (tmp_path / "o").exists()


def test_a_control_character_of_an_unknown_key_is_printable(tmp_path):
    with pytest.raises(InputError, match=r"case.toml: a\\x00b: unknown key"):
        checked_case({**tomllib.loads(_ball("")), "a\0b": 1}, tmp_path / "case.toml")


ODD = ["x`touch P`", "x$(touch P)", "two words", "a;touch P", "a#b", "-n"]


def test_names_of_folders_and_files_are_no_commands(project):
    """A folder or file that make cannot name is left out, and make says so."""
    project.case("one", _ball(""))
    for name in ODD:
        project.case(name, _ball(""))
        for kind in ("sections", "shells"):
            (project.folder / "cases" / kind).mkdir(exist_ok=True)
            (project.folder / "cases" / kind / f"{name}.toml").write_text("")
    told = project.make("-n", "cases", "sections", "shells").stdout
    for name in ODD:
        for file in (f"{name}/case.toml", f"sections/{name}.toml", f"shells/{name}.toml"):
            assert f"cases/{file}" in told
    assert "not seen by make: expected another name" in told
    project.make("sections", "shells")
    assert project.make("one").returncode == 0
    _no_command_ran(project)


def test_a_case_of_the_name_of_a_target_is_told(project):
    for name in ("one", "clean", "compiled", "one-coarse", "one-sweep-x", "shell-x"):
        project.case(name, _ball(""))
    told = project.make("-n", "one").stdout
    assert (
        "cases/clean: cases/compiled: cases/one-coarse: cases/one-sweep-x: cases/shell-x: " in told
    )
    assert "not seen by make: expected another name, make has a target" in told
    assert "plymotion cases/one/case.toml" in told
    assert (project.folder / "build").is_dir()


@pytest.mark.parametrize("planted", ["one", "one-coarse", "sections", "shells"])
def test_no_planted_link_is_followed_under_make(project, repository, tmp_path, planted):
    """The folder is that of the command, not one that the user has named."""
    project.case("one", _ball(""))
    words = {"one-coarse": ["one COARSE=1"]}.get(planted, [planted])
    if planted in ("sections", "shells"):
        (project.folder / f"cases/{planted}").mkdir()
        name = {"sections": "square", "shells": "plate-cantilever"}[planted]
        source = repository / f"cases/{planted}/{name}.toml"
        shutil.copy(source, project.folder / f"cases/{planted}")
        words.append(f"{planted[:-1]}-{name}")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (project.folder / "build" / planted).symlink_to(elsewhere, target_is_directory=True)
    for word in words:
        done = project.make(*word.split())
        assert done.returncode != 0
        assert f"build/{planted} is a link to {elsewhere}" in done.stdout, done.stdout
        assert not any(elsewhere.iterdir())
