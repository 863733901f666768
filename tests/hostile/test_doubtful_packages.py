"""What `validate` calls an error, no command computes with."""

import json
import shutil

import h5py
import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package.common.container import content_sha256, get_text, set_text

ARM = "tests/packages/double-pendulum-limits/arm.isotropic-paper.vtkhdf"
CASE = HEAD + '[bodies.arm]\nkind = "package"\npackage = "arm.vtkhdf"\n' + SOLVER
SWEEP = '[sweeps.s]\nrun = "base"\nvary = { "gravity.1" = [0.0, -1.0] }\n'


def _factor(name, factor):
    def change(file):
        file[f"modal_package/{name}"][...] = file[f"modal_package/{name}"][()] * factor

    return change


def _shape(file):
    group = file["modal_package/interfaces"]
    data = group[next(iter(group))]["phi_B"]
    data[...] = data[()] + 1.0


def _damping(file):
    file["modal_package/modes/damping"][0, 0] = -1.0


def _overdamped(file):
    modes = file["modal_package/modes"]
    modes["damping"][...] = np.diag(400.0 * modes["frequencies"][()])


def _units(file):
    set_text(file, "units", "mm")


def _nan(file):
    file["modal_package/modes/stiffness"][0, 0] = float("nan")


DOUBTFUL = {
    "mass x 1000": (_factor("invariants/mass", 1e3), "invariants/mass: expected the sum of nodal"),
    "interface shapes": (_shape, "differs by 1 from the mode shapes of its nodes"),
    "damping": (_damping, "feeds energy into the body"),
    "no vibration": (_overdamped, "modes/damping: smallest damping ratio 200: expected less than"),
}
UNUSABLE = {
    "units": (_units, "attribute units: expected 'SI', found 'mm'"),
    "stiffness": (_factor("modes/stiffness", -1.0), "modes/stiffness"),
    "not finite": (_nan, "modes/stiffness"),
}


@pytest.fixture
def files(repository, tmp_path):
    """A package that a test changes, and a run and a sweep of it."""
    package = tmp_path / "arm.vtkhdf"
    shutil.copy(repository / ARM, package)
    text = CASE.format(t_end=1e-4, step=1e-4, more="") + SWEEP
    (tmp_path / "case.toml").write_text(text.replace("[solver]", "gravity = [0, 0, 0]\n[solver]"))
    (tmp_path / "case.toml").write_text("gravity = [0.0, 0.0, 0.0]\n" + text)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    return package, tmp_path / "build/runs/base.json", tmp_path / "build/sweeps/s.json"


def _change(package, change):
    with h5py.File(package, "r+") as file:
        change(file)
        body, units = get_text(file, "body"), get_text(file, "units")
        set_text(file, "content_sha256", content_sha256(file["modal_package"], body, units))


@pytest.mark.provokes("package-doubtful")
@pytest.mark.parametrize("name", DOUBTFUL)
def test_contradictions_are_refused_or_warnings(files, capsys, name):
    package, run, sweep = files
    assert main(["run", str(run), "--quiet"]) == 0
    change, words = DOUBTFUL[name]
    _change(package, change)
    capsys.readouterr()
    assert main(["info", str(package)]) == 2
    validated = capsys.readouterr().out
    line = next(line for line in validated.splitlines() if words in line)
    message = line.partition(": error: ")[2]
    assert main(["run", str(run), "--quiet"]) == 2
    told = capsys.readouterr().err
    assert "arm.vtkhdf: " in told
    assert words in told or message.partition(": ")[0].split("/")[2] in told
    assert main(["sweep", str(sweep), "--quiet", "--no-figures"]) == 3
    assert "2 failed" in capsys.readouterr().out
    code = main(["run", str(run), "--quiet", "--allow-doubtful"])
    assert code in (0, 3)
    summary = json.loads((run.parent.parent / "base/summary.json").read_text())
    doubts = [w["message"] for w in summary["warnings"] if w["code"] == "package-doubtful"]
    assert any(words in doubt for doubt in doubts)


@pytest.mark.parametrize("name", UNUSABLE)
def test_unusable_packages_are_refused_always(files, capsys, name):
    package, run, _ = files
    change, words = UNUSABLE[name]
    _change(package, change)
    assert main(["info", str(package)]) == 2
    assert words in capsys.readouterr().out
    for more in ([], ["--allow-doubtful"]):
        assert main(["run", str(run), "--quiet", *more]) == 2
        assert words in capsys.readouterr().err
