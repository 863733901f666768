"""Derivatives of runs: closed forms, six-point differences, refusals, the command and its file."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from samples.case_samples import HEAD, case_runs
from samples.coordinate_samples import carriage, force, wheel
from samples.sensitivity_scenes import (
    PID,
    SCENES,
    STOP,
    Scene,
    differences,
    errors,
    scaled,
    specification,
    with_modulus,
)

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.package import read_package, write_package
from plymotion.solver.package.common.design import Derivative
from plymotion.solver.results import read_result
from plymotion.solver.studies.sensitivities.differentiated_run import with_sensitivities
from plymotion.solver.studies.sensitivities.parameters import design_parameter

TESTED = (
    "spring pendulum",
    "spatial double pendulum",
    "equilibrium start",
    "filtered pid",
    "sampled pid",
    "table",
    "drive",
    "elastic stop",
)


def derivatives(scene, folder, rtol=1e-10):
    """Result, and derivatives by signal and key."""
    result, _ = with_sensitivities(*specification(scene, folder, rtol))
    return result, {(s.signal, s.parameter): s.values for s in result.sensitivities}


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("name", TESTED)
def test_against_differences(name, tmp_path):
    scene = SCENES[name]
    found = errors(scene, tmp_path, 1e-8, scene.keys[:1] + scene.keys[-2:])
    assert found
    assert max(found.values()) < 2e-6, max(found, key=found.get)


def test_a_spring_and_a_mass(tmp_path):
    """x = a + (v / w) sin(w t) - a cos(w t) with w^2 = k / m: all derivatives in closed form."""
    k, m, v, a = 40.0, 1.3, 0.5, 0.2
    spring = force("c", "controller", joint="rail", coordinate="z", proportional=k, setpoint=str(a))
    keys = ("forces.c.proportional", "bodies.car.mass", "bodies.car.velocity.0")
    result, found = derivatives(Scene(carriage(spring, mass=m, speed=v), keys, 2.0), tmp_path)
    t, w = result.t, np.sqrt(k / m)
    by_w = v * t / w * np.cos(w * t) + (a * t - v / w**2) * np.sin(w * t)
    expected = by_w * w / (2.0 * k), -by_w * w / (2.0 * m), np.sin(w * t) / w
    for key, values in zip(keys, expected, strict=True):
        np.testing.assert_allclose(found["x", key], values, atol=1e-7 * np.abs(values).max())


def test_the_period_of_a_pendulum(tmp_path):
    """Small swings: angle = w0 / w sin(w t) with w^2 = m g d / J."""
    text = SCENES["spring pendulum"].text
    text = (
        text[: text.index("[forces.spring]")] + '[signals.angle]\nkind = "joint"\njoint = "hinge"\n'
    )
    start = "centre = [0.0, 0.0, -0.5]\nangular_velocity = [0.0, 1e-4, 0.0]"
    text = text.replace("centre = [0.5, 0.0, 0.0]", start)
    tight = "atol_position = 1e-14\natol_velocity = 1e-14\n"
    scene = Scene(text, ("gravity.2",), 2.0, head="gravity = [0.0, 0.0, -9.81]\n", solver=tight)
    result, found = derivatives(scene, tmp_path)
    w, t = np.sqrt(2.0 * 9.81 * 0.5 / (0.7 + 2.0 * 0.25)), result.t
    by_w = 1e-4 * (t * np.cos(w * t) / w - np.sin(w * t) / w**2)
    expected = by_w * w / (2.0 * -9.81)
    size = np.abs(expected).max()
    np.testing.assert_allclose(found["angle", "gravity.2"], expected, atol=1e-6 * size)


def test_an_impact_with_restitution(tmp_path):
    """A mass hits at v and leaves at e v after a time that does not depend on v (exponent 1).

    Behind the impact x = L - e v (t - L / v - T): dx/dv = (x - L) / v - e L / v, dx/dL = 1 + e,
    and the speed -e v.
    """
    e, v, L = 0.7, 1.0, 0.5
    stop = force("stop", "limit_stop", restitution=e, **STOP)
    keys = ("bodies.car.velocity.0", "forces.stop.upper", "forces.stop.restitution")
    result, found = derivatives(Scene(carriage(stop, speed=v), keys, 1.0), tmp_path)
    x, after = next(s.values for s in result.signals if s.name == "x"), result.t > 0.6
    expected = {
        ("x", keys[0]): (x - L) / v - e * L / v,
        ("v", keys[0]): np.full(x.size, -e),
        ("x", keys[1]): np.full(x.size, 1.0 + e),
        ("v", keys[2]): np.full(x.size, -v),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(found[name][after], values[after], atol=1e-6)


def test_a_ball_dropped_on_a_hard_stop(tmp_path):
    """A contact of 2 ms after which most of the tangent within it has cancelled.

    With z = w s / 2, its depth g / w^2 (1 - cos w s) + v / w sin w s ends at tan z = -v w / g.
    """
    g, L, m, k = 9.81, 0.3, 3.0, 1e7
    law = STOP | {"upper": L, "stiffness": k}
    fall = Scene(
        carriage(force("stop", "limit_stop", **law), mass=m),
        ("gravity.0", "bodies.car.mass"),
        0.4,
        head=f"gravity = [{g}, 0.0, 0.0]\n",
    )
    result, found = derivatives(fall, tmp_path)

    def place(g, m):
        v, w = np.sqrt(2.0 * g * L), np.sqrt(k / m)
        s = result.t - v / g - 2.0 * (np.pi - np.arctan(v * w / g)) / w
        return L - v * s + 0.5 * g * s**2

    after, h = result.t > 0.26, 1e-4
    for key, low, high in (
        ("gravity.0", place(g - h, m), place(g + h, m)),
        ("bodies.car.mass", place(g, m - h), place(g, m + h)),
    ):
        expected = ((high - low) / (2.0 * h))[after]
        assert np.abs(found["x", key][after] - expected).max() < 1e-5 * np.abs(expected).max()


def test_the_stiffness_of_a_flexible_body(repository, tmp_path):
    """Young's modulus, K' = K / E in the package: motion, torques, margins of plies."""
    file = case_runs(repository, "robot-arm", tmp_path) / "base.json"
    changes = {"t_end": 0.25, "output_step": 0.05, "rtol": 1e-10}
    spec = with_modulus(file, "upper", tmp_path, **changes)
    result, _ = with_sensitivities(spec, [design_parameter(spec, "E")])
    expected = differences(lambda x: scaled(spec, "upper", 1.0 + x), 2e-4)
    for one in result.sensitivities:
        values = expected[one.signal]
        assert np.abs(one.values - values).max() < 1e-5 * np.abs(values).max(), one.signal


def _rms(found: pm.Sensitivities, signal: str) -> tuple[float, dict[str, float]]:
    """Root mean square of a signal and its derivatives by those of the signal."""
    x, t = found.signals[signal].values, found.t
    w = np.gradient(t)
    w[[0, -1]] *= 0.5
    value = np.sqrt((w * x**2).sum() / w.sum())
    slopes = {
        key: float((w * x * rate).sum() / w.sum() / value)
        for key, rate in found.derivatives[signal].items()
    }
    return value, slopes


@pytest.mark.parametrize("name", ["spring pendulum", "filtered pid", "drive", "elastic stop"])
def test_adjoint_is_the_tangent_transposed(name, tmp_path):
    scene = SCENES[name]
    specification(scene, tmp_path, 1e-8)
    case = tmp_path / "case.toml"
    tangent = pm.sensitivities(case, of=scene.keys)
    for signal in tangent.signals:
        value, expected = _rms(tangent, signal)
        found = pm.sensitivities(case, of=scene.keys, objective={"signal": signal, "of": "rms"})
        assert found.summary["objective"]["value"] == pytest.approx(value, rel=1e-12)
        size = 2e-8 * max(map(abs, expected.values()))
        assert dict(found.gradient) == pytest.approx(expected, rel=0, abs=size), signal


def test_many_parameters_of_a_body(repository, tmp_path):
    """Sixty that change its stiffness in three ways: tangent and adjoint, beside one alone."""
    packages = shutil.copytree(repository / "tests/packages/robot-arm", tmp_path / "packages")
    file = packages / "upper.base.vtkhdf"
    package, rng = read_package(file), np.random.default_rng(7)
    root = np.linalg.cholesky(package.stiffness)
    ways = [root @ np.diag(rng.uniform(size=len(root))) @ root.T for _ in range(3)]
    design = tuple(
        Derivative(f"g{k}", "number", (), {"modes/stiffness": sum(rng.normal() * w for w in ways)})
        for k in range(60)
    )
    write_package(file, replace(package, design=design))
    case = pm.load(repository / "cases/robot-arm/case.toml")
    case, names = case.changed({"solver.t_end": 0.2}), [one.name for one in design]
    with pytest.raises(InputError, match=r"has derivatives by it .*/design/g60.*did you mean 'g"):
        pm.sensitivities(case, "base", of=[*names, "g60"], packages=packages)
    objective = {"signal": "tip_z", "of": "rms"}
    every = pm.sensitivities(case, "base", of=names, packages=packages)
    adjoint = pm.sensitivities(case, "base", of=names, packages=packages, objective=objective)
    one = pm.sensitivities(case, "base", of=["g7"], packages=packages)
    for signal in ("tip_z", "elbow_torque"):
        rates = every.derivatives[signal]["g7"], one.derivatives[signal]["g7"]
        np.testing.assert_allclose(*rates, rtol=0, atol=1e-6 * np.abs(rates[1]).max())
    expected = _rms(every, "tip_z")[1]
    size = 1e-6 * max(map(abs, expected.values()))
    assert dict(adjoint.gradient) == pytest.approx(expected, rel=0, abs=size)


REFUSED = {
    "bend": (
        Scene(carriage(force("c", "controller", upper=5.0, **PID)), ("bodies.car.mass",)),
        r"forces\.c: its force or state has a bend or jump",
    ),
    "corner": (
        Scene(
            '[tables.c]\nx = [-9, 0.3, 9]\ny = [9, -0.3, -90]\ninterpolation = "linear"\n'
            + carriage(force("c", "coordinate_force", joint="rail", expression="c(x)")),
            ("bodies.car.mass",),
        ),
        r"forces\.c: its force or state has a bend or jump .* corners of a table",
    ),
    "reaction": (
        Scene(
            wheel(force("f", "friction", joint="axle", coefficient=0.1, radius=0.1,
                        rest_velocity=0.1), spin=2.0),
            ("bodies.wheel.mass",),
        ),
        "read reactions",
    ),
    "unknown": (Scene(wheel(), ("bodies.wheel.mas",)), r"--of bodies\.wheel\.mas: unknown key"),
    "solver": (Scene(wheel(), ("solver.t_end",)), r"--of solver\.t_end: expected a number of the"),
    "bound": (
        Scene(SCENES["spring pendulum"].text.replace("damping = 0.5", "damping = 0.0"),
              ("forces.spring.damping",)),
        r"--of forces\.spring\.damping",
    ),
    "moved bend": (
        Scene(
            "[parameters]\nt1 = 0.31\n"
            + SCENES["expression"].text.replace("6 * sin(7 * t) * exp(-t)", "8 * max(0, t1 - t)"),
            ("parameters.t1",),
        ),
        r"parameters\.t1: moves the instant at which a law of time bends or jumps",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_refused_by_name(what, tmp_path):
    scene, words = REFUSED[what]
    with pytest.raises(InputError, match=words):
        derivatives(scene, tmp_path)


def test_a_mass_that_comes_to_rest_in_a_stop(tmp_path):
    """Some impacts, then rest at the depth m g / k."""
    stop = force("stop", "limit_stop", restitution=0.2, **STOP)
    keys = "bodies.car.mass", "gravity.0", "forces.stop.upper"
    scene = Scene(carriage(stop), keys, 3.0, head="gravity = [9.81, 0.0, 0.0]\n")
    _, found = derivatives(scene, tmp_path, 1e-8)
    k = STOP["stiffness"]
    for key, expected in zip(keys, (9.81 / k, 1.0 / k, 1.0), strict=True):
        assert found["x", key][-1] == pytest.approx(expected, rel=1e-5)


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = SCENES["spring pendulum"]
    specification(scene, tmp_path, 1e-6)
    words = ["sensitivities", "case.toml", "--of", "gravity.2", "bodies.rod.mass", "--quiet"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    folder = tmp_path / "build" / tmp_path.name / "sensitivities" / "base"
    assert "bodies.rod.mass" in shown
    assert "peak" in shown
    result = read_result(folder / "result.vtkhdf")
    assert [(s.signal, s.parameter) for s in result.sensitivities[:2]] == [
        ("x", "gravity.2"),
        ("x", "bodies.rod.mass"),
    ]
    assert result.sensitivities[0].unit == "(m)/(m/s2)"
    page = (folder / "report.html").read_text()
    index = json.loads(re.search("id='index'>(.*?)</script>", page)[1])
    assert [run["name"] for run in index["runs"]] == index["figures"][0]["runs"]
    assert set(index["figures"][0]["runs"]) == {"gravity.2", "bodies.rod.mass"}
    assert "energies" not in index["runs"][0]  # they belong to the run
    assert main([*words, "--objective", '{ signal = "x", of = "rms" }']) == 0
    assert capsys.readouterr().out.startswith("signal x rms = ")
    assert not (folder / "report.html").exists()
    page = tmp_path / "mine/sensitivities/base/report.html"
    page.parent.mkdir(parents=True)
    page.write_text("of the user")
    other = [*words, "--out", str(tmp_path / "mine")]
    assert main([*other, "--objective", '{ signal = "x", of = "rms" }']) == 2
    assert "report.html: already exists and was not written by" in capsys.readouterr().err
    assert page.read_text() == "of the user"
    assert main([*words, "--objective", '{ signal = "y", of = "rms" }']) == 2
    assert 'objective.signal = "y": no such signal' in capsys.readouterr().err
    text = (tmp_path / "case.toml").read_text()
    (tmp_path / "case.toml").write_text(text.replace('"radau"', '"rk8"'))
    assert main(words) == 2
    assert 'implemented for "radau" only' in capsys.readouterr().err
    assert HEAD in text
