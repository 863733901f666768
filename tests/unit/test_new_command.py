"""`plymotion new`: each starter case runs as it is; nothing is ever replaced."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.commands.case_arguments import STARTERS
from plymotion.solver.commands.setup import HOME
from plymotion.solver.errors import counted
from plymotion.solver.workers import launch

# Runs of each starter that must end without warnings; notes may be.
RUNS = {
    "arm": ["base"],
    "robot-arm": ["flexible", "rigid"],
    "panel": ["base"],
    "bracket": ["base"],
    "pendulum": ["stiff", "soft"],
    "blade": ["base"],
    "shaft": ["run-up"],
}


def test_every_starter_is_listed() -> None:
    assert {folder.name for folder in HOME.iterdir()} == set(STARTERS) == set(RUNS)


@pytest.mark.parametrize("name", STARTERS)
def test_a_starter_has_no_errors(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", name]) == 0
    assert f"Next: plymotion {name}/case.toml" in capsys.readouterr().out
    assert main(["check", f"{name}/case.toml"]) == 0
    assert f"{counted(len(RUNS[name]), 'run')}, no errors" in capsys.readouterr().out
    text = Path(name, "case.toml").read_text("utf-8")
    assert len(text.splitlines()) < 100
    assert text.count("#") > 5  # it is commented


@pytest.mark.parametrize(
    ("typed", "found", "shown"),
    [
        ("bin/plymotion", False, "bin/plymotion my-arm/case.toml"),
        ("bin/plymotion", True, "plymotion my-arm/case.toml"),
        ("bin/pytest", False, "plymotion my-arm/case.toml"),
    ],
)
def test_the_next_command_is_what_the_user_types(
    typed: str,
    found: bool,
    shown: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The shell finds the command by its name, or the user has typed its path."""
    monkeypatch.chdir(tmp_path)
    program = Path(typed)
    program.parent.mkdir()
    program.touch(mode=0o755)
    monkeypatch.setattr(sys, "argv", [typed, "new"])
    monkeypatch.setenv("PATH", str(program.parent.absolute()) if found else "")
    assert main(["new", "arm", "my-arm"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"Next: {shown}"


@pytest.fixture(scope="module")
def home(fenicsx: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder for all starters, whose bodies one FEniCSx builds."""
    with pytest.MonkeyPatch.context() as patch, launch.kept_preprocessors():
        patch.setenv("FENICSX_PYTHON", fenicsx)
        yield tmp_path_factory.mktemp("starters")


@pytest.mark.parametrize("name", STARTERS)
def test_a_starter_runs_as_it_is(name: str, home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(home)
    mine = f"my-{name}"
    assert main(["new", name, mine]) == 0
    assert main([f"{mine}/case.toml", "--quiet", "--jobs", "1"]) == 0
    assert len({own.start for own in launch._idle}) <= 1, "a process for each folder of bodies"
    assert Path("build", mine, "report.html").is_file()
    for run in RUNS[name]:
        summary = json.loads(Path("build", mine, run, "summary.json").read_text("utf-8"))
        assert summary["completed"]
        assert summary["warnings"] == []
        assert max(abs(s["max"]) for s in summary["signals"].values()) > 0.0
    if name == "robot-arm":
        _lowest_vibrations_are_damped(
            json.loads(Path("build", mine, "flexible/summary.json").read_text("utf-8"))["damping"]
        )


def _lowest_vibrations_are_damped(entries: list[dict[str, float]]) -> None:
    """Its case says 1 % at the 10 Hz of the whole arm; both tubes share the bending after that."""
    upper, fore = entries
    assert upper["frequency_hz"] == pytest.approx(10.0, rel=0.05)
    assert upper["damping_ratio"] == pytest.approx(0.01, rel=0.1)
    assert fore["frequency_hz"] < 1.1 * fore["own_frequency_hz"] < 300.0


def test_a_folder_of_a_case_does_not_hide_the_command_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`plymotion new blade` makes such a folder."""
    monkeypatch.chdir(tmp_path)
    assert main(["new", "blade"]) == 0
    assert main(["blade", "absent.yaml", "--check"]) == 2
    assert "absent.yaml" in capsys.readouterr().err


def test_nothing_is_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "mine"
    assert main(["new", "arm", str(folder)]) == 0
    before = (folder / "case.toml").read_text("utf-8")
    for wrong in (["new", "blade", str(folder)], ["new", "blade", str(folder / "case.toml")]):
        assert main(wrong) == 2
        assert "expected a new" in capsys.readouterr().err
    assert (folder / "case.toml").read_text("utf-8") == before
    assert main(["new", "pendlum", str(tmp_path / "other")]) == 2
    assert "no such starter; did you mean 'pendulum'?" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()
