"""`plymotion plan` and `plymotion run` of a case with [fidelity], with packages built here."""

import json
import os
from pathlib import Path

import pytest
from harness.processes import this_python
from samples.fidelity_packages import CASE, build_bodies

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.report.report_page import make_report
from plymotion.solver.results import read_result, read_summary
from plymotion.solver.run.inputs import up_to_date

ROOT = Path(__file__).resolve().parent.parent.parent


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A checked case, and its packages."""
    root = tmp_path_factory.mktemp("pendulum")
    (root / "case.toml").write_text(CASE)
    out = root / "build"
    ready = root / "packages"
    ready.mkdir()
    words = ["check", str(root / "case.toml"), "--out", str(out), "--packages", str(ready)]
    assert main(words) == 0
    build_bodies(out / "bodies", ready)
    return root


def plan(folder: Path, *more: str) -> int:
    case, out = str(folder / "case.toml"), str(folder / "build")
    return main(["plan", case, "--out", out, "--packages", str(folder / "packages"), *more])


def run(folder: Path, name: str = "base") -> int:
    return main(["run", str(folder / f"build/runs/{name}.json"), "--quiet"])


def test_two_packages_are_specified_for_a_body(folder):
    model, check = (
        json.loads((folder / f"build/bodies/link.base{kind}.json").read_text())
        for kind in ("", ".check")
    )
    assert check["elements"] == 2 * model["elements"]
    count = [sum(m.get("count", 0) for m in spec["modes"]) for spec in (model, check)]
    assert count[1] >= 1.4 * count[0]
    for spec in (model, check):
        assert spec["candidates"] is True
        kinds = [mode["kind"] for mode in spec["modes"]]
        assert {"attachment", "static-inertia", "static-axial"} <= set(kinds)


def test_plan_prints_the_answer_and_run_delivers_the_check(folder, capsys):
    assert plan(folder) == 0
    text = capsys.readouterr().out
    expected = "Estimated error of tip", "Not checked", "The request is met", "rtol"
    for words in (*expected, "Beam theory of link (width 40 mm"):
        assert words in text
    file = folder / "build/plans/base.toml"
    written = file.read_text()
    assert run(folder) == 0
    assert "accuracy 0.01 met: estimated error" in capsys.readouterr().out
    assert file.read_text() == written
    found = read_summary(folder / "build/base/summary.json")["fidelity"]
    keys = {"asked", "metric", "scale", "plan", "estimate", "shares", "cpu", "verdict"}
    assert keys | {"not_checked"} <= set(found)
    assert found["verdict"] == "met"
    assert 0.0 < found["estimate"]["tip"] <= 0.9 * 1e-2
    tried = found["ladder"]
    assert len(tried["rungs"]) >= 2
    assert tried["chosen"]["error"] <= found["estimate"]["tip"] * (1.0 + 1e-9)
    assert read_result(folder / "build/base/result.vtkhdf").t[-1] == pytest.approx(0.1)


def test_two_processes_make_the_same_plan(folder, tmp_path, capsys):
    """And the same estimates, to the last digit; only the times differ."""
    words = ["plan", str(folder / "case.toml"), "--packages", str(folder / "packages"), "--json"]
    # This process has other hashes, and has planned before.
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    more = {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
    other = ["-m", "plymotion", *words, "--out", tmp_path / "other"]
    done = this_python(*other, more=more, check=True)
    assert main([*words, "--out", str(tmp_path / "own")]) == 0
    found = []
    for name, text in (("other", done.stdout), ("own", capsys.readouterr().out)):
        answer = json.loads(text)
        del answer["cpu"]
        found.append((answer, (tmp_path / name / "plans/base.toml").read_text()))
    assert found[0] == found[1]


def test_an_edited_plan_is_checked_and_kept(folder):
    assert plan(folder) == 0
    file = folder / "build/plans/base.toml"
    lines = file.read_text().splitlines()
    edited = [f"rtol = {2e-3}" if line.startswith("rtol") else line for line in lines]
    file.write_text("\n".join(edited))
    run(folder)
    found = read_summary(folder / "build/base/summary.json")["fidelity"]
    assert found["plan"]["rtol"] == 2e-3
    assert found["rounds"] == 1
    assert file.read_text() == "\n".join(edited)


@pytest.mark.parametrize(
    ("line", "new", "message"),
    [
        ("rtol", "rtol = 2.0", "rtol = 2.0: value should be less than or equal to 0.1"),
        ("vibrations", 'vibrations = ["bending-xy 9"]', 'vibrations.0 = "bending-xy 9": no such'),
        ("mesh", 'mesh = "fine"', "mesh = \"fine\": value should be 'model' or 'check'"),
        ("ringing", "rings = true", "rings: unknown key"),
        ("static_shapes", "", "static_shapes: missing"),
    ],
)
def test_a_plan_that_is_wrong_is_refused(folder, capsys, line, new, message):
    assert plan(folder, "--no-check") == 0
    file = folder / "build/plans/base.toml"
    lines = [new if text.startswith(line) else text for text in file.read_text().splitlines()]
    file.write_text("\n".join(lines))
    capsys.readouterr()
    assert run(folder) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "base.toml" in error
    file.unlink()  # the other tests make their own


def test_a_result_is_computed_again_when_its_plan_is_edited(folder):
    """`plymotion CASE` and pm.run keep a result as long as the plan says the same."""
    assert plan(folder) == 0
    assert run(folder) == 0
    run_file, out = folder / "build/runs/base.json", folder / "build/base"
    file = folder / "build/plans/base.toml"
    said = file.read_text()
    file.write_text("# a remark of the user\n" + said)
    assert up_to_date(run_file, out)
    file.write_text("\n".join(said.splitlines()).replace("rtol = ", "rtol = 0.1e-3  # "))
    assert not up_to_date(run_file, out)
    found = pm.run(folder / "case.toml", "base", out=folder / "build", packages=folder / "packages")
    assert found.summary["fidelity"]["plan"]["rtol"] == 1e-4
    assert up_to_date(run_file, out)
    file.unlink()
    assert not up_to_date(run_file, out)


def test_a_folder_in_place_of_the_plan_is_told(folder, capsys):
    file = folder / "build/plans/base.toml"
    file.unlink(missing_ok=True)
    file.mkdir(parents=True)
    assert run(folder) == 2
    assert f"{file}: no such plan" in capsys.readouterr().err
    file.rmdir()


def test_a_plan_of_a_case_that_was_changed_is_made_again(folder, capsys):
    """Its vibrations and bodies may be others: the old plan is not judged."""
    assert plan(folder) == 0
    file = folder / "build/plans/base.toml"
    old = file.read_text().replace("bodies.link", "bodies.arm").replace('sha256 = "', 'sha256 = "0')
    file.write_text(old)
    assert run(folder) == 0
    assert "bodies.link" in file.read_text()
    assert file.with_suffix(".previous.toml").read_text() == old


def test_a_request_that_is_not_met_leaves_a_result(folder, capsys):
    assert run(folder, "impossible") == 3
    assert "not met" in capsys.readouterr().out
    summary = read_summary(folder / "build/impossible/summary.json")
    assert summary["fidelity"]["verdict"] == "not met"
    assert summary["fidelity"]["reason"]
    assert (folder / "build/impossible/result.vtkhdf").is_file()
    assert plan(folder, "--run", "impossible") == 3


def test_the_plan_as_json(folder, capsys):
    assert plan(folder, "--json") == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "met"


def test_a_chart_is_drawn(folder, capsys):
    case, out = str(folder / "case.toml"), str(folder / "build")
    assert (
        main(["plan", "--chart", case, "--out", out, "--packages", str(folder / "packages")]) == 0
    )
    assert "chosen" in capsys.readouterr().out
    assert (folder / "build/plans/base.png").read_bytes().startswith(b"\x89PNG")
    assert run(folder) == 0
    page = make_report(folder / "build", ["base"]).read_text()
    assert "Accuracy asked and estimated" in page
    assert "rigid, rtol 0.001: " in page


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('signals = ["tip"]', 'signals = ["tpi"]', 'fidelity.signals = "tpi": no such signal'),
        ("accuracy = 1e-2", "accuracy = 0", "fidelity.accuracy = 0"),
        ("accuracy = 1e-2", 'accuracy = 1e-2, metric = "max"', "fidelity.metric"),
        (
            "elements = 8",
            'elements = 8\nreduced = [{ kind = "lowest", count = 1 }]',
            "bodies.link.reduced: expected none with [fidelity]",
        ),
    ],
)
def test_a_wrong_request_is_reported(tmp_path, capsys, old, new, message):
    file = tmp_path / "case.toml"
    file.write_text(CASE.replace(old, new))
    assert main(["check", str(file)]) == 2
    assert message in capsys.readouterr().err


def test_a_case_without_fidelity_has_no_plan(tmp_path, capsys):
    file = tmp_path / "case.toml"
    file.write_text(CASE.replace("fidelity = { accuracy = 1e-2", "#"))
    assert main(["plan", str(file), "--out", str(tmp_path)]) == 2
    assert "run base has no [fidelity]" in capsys.readouterr().err
