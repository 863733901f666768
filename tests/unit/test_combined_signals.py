"""Differences and norms of signals, also to another run, in runs and in sweeps."""

import json
import re

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.sweep.file import read_sweep

# Two balls on a plane, thrown; the run "calm" has no gravity and half the speed along x.
BALLS = (
    HEAD
    + "gravity = [0.0, -10.0, 0.0]\n"
    + rigid("one", 1.0, 0.1, {"c": (0, 0, 0)}, velocity=[2.0, 0.0, 0.0])
    + rigid("two", 1.0, 0.1, {"c": (0, 0, 0)}, velocity=[0.0, 3.0, 0.0])
    + "".join(
        f'[signals.{body}_{axis}]\nkind = "position"\nat = "{body}.c"\ncomponent = "{axis}"\n'
        for body in ("one", "two")
        for axis in ("x", "y")
    )
    + SOLVER.format(t_end=1.0, step=0.1, more="")
    + """
[runs.calm]
variants = ["calm"]
[variants.calm]
gravity = [0.0, 0.0, 0.0]
bodies.one.velocity = [1.0, 0.0, 0.0]
"""
)
COMBINED = """
[signals.apart]
kind = "difference"
of = "one_x"
minus = "two_y"
[signals.error]
kind = "norm"
of = ["one_x", "one_y"]
run = "calm"
description = "distance to the calm ball"
[signals.fall]
kind = "difference"
of = "two_y"
run = "calm"
[signals.across]
kind = "difference"
of = "one_x"
minus = "two_x"
run = "calm"
[signals.double]
kind = "norm"
of = ["fall", "fall"]
divide_by = 2.0
[signals.half]
kind = "norm"
of = ["fall"]
divide_by = 2.0
keep_unit = true
"""


def _write(folder, text):
    folder.mkdir(exist_ok=True)
    file = folder / "case.toml"
    file.write_text(text)
    case = load_case(file)
    write_case(case, folder / "build")
    return folder / "build"


def _run(folder, name="base"):
    result, summary = execute(read_run(folder / f"runs/{name}.json"), progress=False)
    return result.t, {s.name: s for s in result.signals}, summary


def test_closed_forms(tmp_path):
    t, found, summary = _run(_write(tmp_path, BALLS + COMBINED))
    values = {name: signal.values for name, signal in found.items()}
    np.testing.assert_allclose(values["apart"], 2 * t - (3 * t - 5 * t**2), atol=1e-9)
    np.testing.assert_allclose(values["error"], np.hypot(t, 5 * t**2), atol=1e-9)
    np.testing.assert_allclose(values["fall"], -5 * t**2, atol=1e-9)
    np.testing.assert_allclose(values["across"], 2 * t, atol=1e-9)
    np.testing.assert_allclose(values["double"], 5 * t**2 / np.sqrt(2.0), atol=1e-9)
    assert [found[n].unit for n in ("error", "fall", "double", "half")] == ["m", "m", "-", "m"]
    assert summary["signals"]["fall"]["peak_to_peak"] == pytest.approx(5.0, abs=1e-9)
    assert summary["signals"]["error"]["max"] == pytest.approx(np.sqrt(26.0), abs=1e-9)


def test_the_other_run_has_the_times_of_this_one(tmp_path):
    """Not values between its own times by straight lines: 0.1 m off here."""
    text = (BALLS + COMBINED).replace(
        "[variants.calm]\n", "[variants.calm]\nsolver = { output_step = 0.3, t_end = 0.9 }\n"
    )
    t, found, _ = _run(_write(tmp_path, text.replace("gravity = [0.0, 0.0, 0.0]", "")))
    fall = found["fall"].values
    assert np.isnan(fall[t > 0.9001]).all()
    np.testing.assert_allclose(fall[t < 0.9001], 0.0, atol=1e-9)


def test_a_run_has_no_difference_to_itself(tmp_path):
    _, found, _ = _run(_write(tmp_path, BALLS + COMBINED), "calm")
    assert np.array_equal(found["fall"].values, np.zeros(11))
    assert np.array_equal(found["error"].values, np.zeros(11))


def test_other_output_times_and_an_earlier_end(tmp_path):
    short = "[variants.calm.solver]\nt_end = 0.5\noutput_step = 0.05\n"
    t, found, _ = _run(_write(tmp_path, BALLS + COMBINED + short))
    values = found["fall"].values
    np.testing.assert_allclose(values[:6], -5 * t[:6] ** 2, atol=1e-9)
    assert np.isnan(values[6:]).all()
    assert np.isfinite(found["two_y"].values).all()


def test_a_change_of_the_other_run_makes_the_result_out_of_date(tmp_path, capsys):
    build = _write(tmp_path, BALLS + COMBINED)
    words = ["run", "--update", "--quiet", str(build / "runs/base.json")]
    assert main(words) == 0
    assert main(words) == 0
    assert "base: up to date" in capsys.readouterr().out
    _write(tmp_path, BALLS.replace("velocity = [1.0, 0.0", "velocity = [1.5, 0.0") + COMBINED)
    assert main(words) == 0
    assert "base: done" in capsys.readouterr().out


SWEEP = """
[sweeps.s]
run = "base"
signals = ["error", "fall"]
histories = ["double"]
[sweeps.s.vary]
"bodies.two.velocity.1" = [3.0, 6.0]
"gravity.1" = [-10.0, -20.0]
"""


def test_members_of_a_sweep_are_compared_with_the_other_run_of_the_same_values(tmp_path):
    """Gravity is set in both runs, so that nothing of the fall remains."""
    build = _write(tmp_path, BALLS + COMBINED + SWEEP)
    assert main(["sweep", str(build / "sweeps/s.json"), "--quiet", "--no-figures"]) == 0
    found = read_sweep(build / "sweeps/s/sweep.h5")
    np.testing.assert_allclose(found.signal("fall", "min"), 0.0, atol=1e-12)
    np.testing.assert_allclose(found.signal("error", "max"), 1.0, atol=1e-9)
    np.testing.assert_allclose(found.signal("error", "rms"), np.sqrt(1 / 3), rtol=3e-3)
    np.testing.assert_allclose(found.history("double"), 0.0, atol=1e-12)
    table = json.loads((build / "sweeps/s.json").read_text())
    assert [m["other_runs"]["calm"]["changes"] for m in table["members"]][-1] == {
        "bodies.two.velocity.1": 6.0,
        "gravity.1": -20.0,
    }


BAD = {
    "no such run": ('run = "clam"', r's\.run = "clam": no such run; did you mean .calm'),
    "nothing to subtract": ("", "expected `minus`, `run` or both"),
    "no such signal": ('minus = "one_z"', 'of = "one_z": no such signal; did you mean'),
    "itself": ('minus = "s"', "depends on itself"),
    "another unit": ('minus = "spin"', "signals of one unit, found m and rad/s"),
    "another unit of another run": ('minus = "spin"\nrun = "calm"', "found m and rad/s"),
}


@pytest.mark.parametrize("name", BAD)
def test_wrong_combinations(name, tmp_path):
    keys, expected = BAD[name]
    text = f"""
[signals.spin]
kind = "angular_velocity"
at = "one.c"
component = "x"
[signals.s]
kind = "difference"
of = "one_x"
{keys}
"""
    with pytest.raises(InputError) as error:
        _run(_write(tmp_path, BALLS + text))
    assert re.search(expected, str(error.value)), error.value
    assert len(str(error.value).splitlines()) == 1


def test_a_sweep_of_a_signal_of_a_run_that_is_not_there(tmp_path):
    """A run that was renamed: said once, also where the sweep and the coarse version need it."""
    more = (
        '[coarse.solver]\noutput_step = 0.2\n[sweeps.s]\nrun = "base"\n'
        'vary = { "bodies.one.mass" = [1.0, 2.0] }\nsignals = ["fall"]\n'
    )
    text = (BALLS + COMBINED).replace("[runs.calm]", "[runs.quiet]") + more
    with pytest.raises(InputError) as error:
        _write(tmp_path, text)
    found = str(error.value).splitlines()
    assert all('run = "calm"' in line for line in found), found
