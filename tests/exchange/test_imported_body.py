"""`kind = "imported"` in a case: checked, built and run like any other body."""

from pathlib import Path

import pytest
from samples.exchange_samples import bar, write_matrices

from plymotion.preprocess.__main__ import main as preprocess
from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.bodies.specifications import imported_spec
from plymotion.solver.inputs.case.load import load_case, source_files
from plymotion.solver.inputs.case.tables.bodies import ImportedBody
from plymotion.solver.package import read_package
from plymotion.solver.results import read_result

CASE = """\
format = 1
title = "An imported arm"
gravity = [0.0, 0.0, -9.81]

[bodies.link]
kind = "imported"
import = "arm.toml"

[joints.root]
kind = "fixed"
between = ["ground.origin", "link.root"]

[ground.origin]
position = [0.0, 0.0, 0.0]

[signals.tip_z]
kind = "position"
at = "link.tip"
component = "z"

[solver]
t_end = 0.01
output_step = 1e-3

[runs.base]
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    write_matrices(tmp_path, bar())
    file = tmp_path / "case.toml"
    file.write_text(CASE)
    return file


def test_case_is_built_and_run(
    case: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "build"
    assert main(["check", str(case), "--out", str(out)]) == 0
    (spec,) = (out / "bodies").glob("*.json")
    words = ["body", str(spec), "--out-dir", str(out / "bodies")]
    assert preprocess(words) == 0
    package = read_package(spec.with_suffix(".vtkhdf"))
    assert package.body == "link"
    assert preprocess(words) == 0
    assert "unchanged" in capsys.readouterr().out
    assert main(["run", str(out / "runs" / "base.json"), "--quiet"]) == 0
    result = read_result(out / "base" / "result.vtkhdf")
    assert result.signals[0].values.min() < -1e-5


def test_a_change_of_a_matrix_builds_the_body_again(
    case: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "build"
    assert main(["check", str(case), "--out", str(out)]) == 0
    names = {file.name for file in source_files(load_case(case))}
    assert {"arm.toml", "K.mtx", "dofs.csv"} <= names
    (spec,) = (out / "bodies").glob("*.json")
    with (tmp_path / "nodes.csv").open("a") as stream:
        stream.write("# a remark\n")
    assert preprocess(["body", str(spec), "--out-dir", str(out / "bodies")]) == 2
    told = capsys.readouterr()
    assert "nodes.csv: changed since `plymotion check`" in told.out + told.err
    text = spec.read_text()
    assert main(["check", str(case), "--out", str(out)]) == 0
    assert spec.read_text() != text


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('import = "arm.toml"', 'import = "arn.toml"', 'bodies.link.import = "arn.toml": '),
        ('import = "arm.toml"', 'package = "arm.toml"', "bodies.link.package: unknown key"),
    ],
)
def test_wrong_cases_are_refused(
    case: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    case.write_text(CASE.replace(old, new))
    assert main(["check", str(case)]) == 2
    assert message in capsys.readouterr().err


def test_files_of_a_deck_in_another_folder_are_known(tmp_path: Path) -> None:
    """Those beside the deck, and those that it includes: a body is made again if they change."""
    for name, text in (
        ("arm.toml", 'from = "calculix-modes"\n[files]\ndeck = "decks/arm.inp"\n'),
        ("decks/arm.inp", "*Include, Input=mesh.inp\n** *INCLUDE, INPUT=other.inp\n"),
        ("decks/mesh.inp", "*NODE\n"),
        ("decks/other.inp", "*NODE\n"),
        ("decks/arm.frd", ""),
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    body = ImportedBody(kind="imported", file="arm.toml")
    spec, files = imported_spec("link", body, tmp_path)
    assert set(spec["sha256"]) == {f"decks/{name}" for name in ("arm.inp", "mesh.inp", "arm.frd")}
    assert tmp_path / "decks/mesh.inp" in files
