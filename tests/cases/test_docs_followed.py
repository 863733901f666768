"""First steps, README and a mechanism followed as they are written, in a folder of their own."""

import re
import tomllib
from pathlib import Path

import pytest

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.workers.launch import kept_preprocessors

BLOCK = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_first_steps(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fenicsx: str
) -> None:
    arm, variants = BLOCK.findall((repository / "docs/first-steps.md").read_text("utf-8"))
    monkeypatch.chdir(tmp_path)
    with kept_preprocessors():
        Path("arm.toml").write_text(arm)
        assert main(["arm.toml", "--quiet"]) == 0
        assert "A driven laminated arm" in Path("build/arm/report.html").read_text()
        Path("arm.toml").write_text(arm + variants)
        assert main(["arm.toml", "--quiet"]) == 0
    both = [pm.Result.from_folder(f"build/arm/{run}") for run in ("base", "zero")]
    assert all(result.completed and not result.warnings for result in both)
    base, zero = (abs(result.signals["tip_bending"]).max for result in both)
    assert zero < 0.5 * base, "fibres along the beam make it stiffer"


def test_names_of_the_readme_are_those_of_the_starter(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (repository / "README.md").read_text("utf-8")
    (file,) = re.findall(r'pm\.load\("(.*?)"\)', text)
    (run,) = re.findall(r'pm\.run\(case, "(.*?)"\)', text)
    (signal,) = re.findall(r'result\.signals\["(.*?)"\]', text)
    monkeypatch.chdir(tmp_path)
    assert main(["new", Path(file).parent.name]) == 0
    found = tomllib.loads(Path(file).read_text("utf-8"))
    assert run in found["runs"]
    assert signal in found["signals"]


def test_the_closed_loop(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fenicsx: str
) -> None:
    """It closes where the page puts its bodies, and has the values of the page."""
    (text,) = BLOCK.findall((repository / "docs/four-bar.md").read_text("utf-8"))
    monkeypatch.chdir(tmp_path)
    Path("four-bar.toml").write_text(text)
    assert main(["four-bar.toml", "--quiet", "--no-report"]) == 0
    result = pm.Result.from_folder("build/four-bar/base")
    assert not result.warnings
    assert abs(result.signals["bending"]).max == pytest.approx(6.3e-6, rel=0.01)
    assert abs(result.signals["torque"]).max == pytest.approx(0.12, rel=0.01)
