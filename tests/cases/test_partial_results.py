"""Runs that do not reach their end keep what they have, readable, and say why."""

import json

import numpy as np
import pytest
from harness.processes import interrupted
from samples.case_samples import HEAD, SOLVER, case_runs, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package.common.files import RECORD
from plymotion.solver.results import read_result


def _checked_result(out):
    summary = json.loads((out / "summary.json").read_text())
    result = read_result(out / "result.vtkhdf")
    assert not summary["completed"]
    assert summary["t_end"] == pytest.approx(result.t[-1])
    assert all(
        np.isfinite(values).all() for values in (result.q, result.v, result.energies["kinetic"])
    )
    assert {path.name for path in out.iterdir()} == {"summary.json", "result.vtkhdf", RECORD}
    return summary, result


@pytest.mark.provokes("run-interrupted")
def test_ctrl_c_keeps_the_part(repository, tmp_path):
    runs = case_runs(repository, "n-four-bar", tmp_path / "build")
    file, out = runs / "n-2.json", tmp_path / "out"
    spec = json.loads(file.read_text())
    spec["mechanism"]["solver"] |= {"t_end": 1e4, "output_step": 0.05}
    file.write_text(json.dumps(spec))
    ready = (
        "import sys, plymotion.solver.run.execution as r\n"
        "from plymotion.solver.__main__ import main\n"
        "step = r.Progress.__call__\n"
        "def told(self, i):\n"
        "    print('stepping', flush=True) if i.t[-1] > 0.3 else None\n"
        "    return step(self, i)\n"
        "r.Progress.__call__ = told\n"
        "r.PATIENCE_S = 60.0  # a busy machine may need longer to save\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    code, words, _ = interrupted(ready, "run", file, "--out", out, "--quiet")
    assert code == 130
    assert "n-2: interrupted at t = " in words
    summary, result = _checked_result(out)
    assert summary["status"] == "interrupted"
    assert "run-interrupted" in [w["code"] for w in summary["warnings"]]
    assert 0.1 < result.t[-1] < 1e4  # the step that was interrupted is not kept
    np.testing.assert_allclose(np.diff(result.t[:-1]), 0.05, rtol=1e-9)


def test_step_underflow_keeps_the_part(tmp_path, capsys):
    """A force that grows beyond all numbers: no step is short enough."""
    text = HEAD + (
        rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
        + '[forces.push]\nkind = "force"\nat = "ball.c"\ndirection = [1.0, 0.0, 0.0]\n'
        "law = { polynomial = [0.0, 0.0, 0.0, 1e300] }\n"
        + SOLVER.format(t_end=1.0, step=0.01, more="")
    )
    (tmp_path / "case.toml").write_text(text)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    out = tmp_path / "out"
    code = main(["run", str(tmp_path / "build/runs/base.json"), "--out", str(out), "--quiet"])
    assert code == 3
    summary, result = _checked_result(out)
    assert summary["status"] == "failed"
    assert "step" in summary["message"]
    assert "error [run-failed]" in capsys.readouterr().out
    assert result.t[-1] < 1.0


@pytest.mark.parametrize("name", ["missing", "half"])
def test_a_run_that_cannot_begin_leaves_nothing(name, tmp_path, capsys):
    file = tmp_path / "runs" / "base.json"
    file.parent.mkdir()
    if name == "half":
        file.write_text('{"case": "x", "run"')
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 2
    assert "base.json" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
