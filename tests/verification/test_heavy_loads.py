"""Heavy masses on light bodies, up to a ratio of 1e9: they start, and move as closed forms say."""

import shutil

import numpy as np
import pytest
from samples.case_samples import HEAD, case_runs, rigid
from samples.mechanism_samples import GRAVITY, GROUND, Rods
from scipy.integrate import solve_ivp

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.mechanism.consistent import consistent_state, redundancy
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.preparation import prepare

RATIOS = (1e4, 1e6, 1e9)
G, ROD, LENGTH = 9.81, 1e-3, 1.0


def _spec(folder, text, solver, packages=None):
    file = folder / "case.toml"
    file.write_text(f"{HEAD}{text}\n[solver]\n{solver}\n[runs.base]\n")
    write_case(load_case(file), folder / "build", packages)
    return read_run(folder / "build/runs/base.json")


def _pendulum(folder, ratio, drive=""):
    """A light rod on a hinge with a heavy mass on a ball joint at its end, from the horizontal."""
    text = (
        f"gravity = [0.0, {-G}, 0.0]\n[ground]\nO = {{ position = [0.0, 0.0, 0.0] }}\n"
        + rigid("rod", ROD, ROD / 12, {"a": [-0.5, 0, 0], "b": [0.5, 0, 0]}, position=[0.5, 0, 0])
        + rigid("load", ROD * ratio, 1e-2 * ROD * ratio, {"c": [0, 0, 0]}, position=[1, 0, 0])
        + '[joints.foot]\nkind = "revolute"\nbetween = ["ground.O", "rod.a"]\naxis = [0, 0, 1.0]\n'
        + drive
        + '[joints.ball]\nkind = "spherical"\nbetween = ["rod.b", "load.c"]\n'
    )
    return _spec(folder, text, "t_end = 0.5\noutput_step = 0.1\nrtol = 1e-6")


@pytest.mark.parametrize("ratio", RATIOS)
def test_a_heavy_mass_on_a_light_rod_swings_as_a_pendulum(ratio, tmp_path):
    """In as many steps as any pendulum: Newton's matrix does not take the rows for dependent."""
    ready = prepare((spec := _pendulum(tmp_path, ratio)).mechanism, spec.packages)
    made = make_integrator(ready.model, ready.y0, spec.mechanism.solver, ready.treatment)
    solution = integrate(made, [0.0, 0.5])
    assert solution.status == "finished"
    assert solution.counters.steps + solution.counters.rejected < 60
    inertia, moment = ROD / 3 + ROD * ratio, ROD * (0.5 + ratio)
    angle = solve_ivp(
        lambda t, z: [z[1], -G * moment / inertia * np.cos(z[0])],
        (0.0, 0.5),
        [0.0, 0.0],
        rtol=1e-11,
        atol=1e-12,
    ).y[0, -1]
    np.testing.assert_allclose(
        solution.y[-1, 7:9], [np.cos(angle), np.sin(angle)], atol=2e-5, rtol=0
    )


@pytest.mark.parametrize("ratio", RATIOS)
def test_a_heavy_point_mass_on_a_light_rod_swings_as_a_pendulum(ratio, tmp_path):
    """In space, the rod turning about itself; 1e9 took 271,882 steps as a part of the rod."""
    thin = (1e-4 * ROD / 12, ROD / 12, ROD / 12)
    text = (
        f"gravity = [0.0, {-G}, 0.0]\n[ground]\nO = {{ position = [0.0, 0.0, 0.0] }}\n"
        + rigid(
            "rod",
            ROD,
            thin,
            {"a": [-0.5, 0, 0], "b": [0.5, 0, 0]},
            position=[0.5, 0, 0],
            angular_velocity=[3.0, 1.0, 0.5],
        )
        + f'[masses.load]\nmass = {ROD * ratio}\nat = "rod.b"\n'
        + '[joints.foot]\nkind = "spherical"\nbetween = ["ground.O", "rod.a"]\n'
        + "".join(
            f'[signals.{c}]\nkind = "position"\nat = "rod.b"\ncomponent = "{c}"\n' for c in "xyz"
        )
    )
    result, summary = execute(
        _spec(tmp_path, text, "t_end = 1.0\noutput_step = 0.1\nrtol = 1e-7"), progress=False
    )
    assert summary["cost"]["steps"] + summary["cost"]["rejected"] < 150
    weight = G * (0.5 + ratio) / (1.0 / 3.0 + ratio)

    def rates(t, z):  # a spherical pendulum in Cartesian coordinates; the rod's spin is too small
        r, v = z[:3], z[3:]
        g = np.array([0.0, -weight, 0.0])
        return [*v, *(g - (g @ r + v @ v) * r)]

    start = [1.0, 0.0, 0.0, 0.0, 0.5, -1.0]
    expected = solve_ivp(rates, (0, 1), start, t_eval=result.t, rtol=1e-11, atol=1e-12).y[:3]
    found = np.array([s.values for s in result.signals])
    np.testing.assert_allclose(found, expected, atol=1e-5 + 0.1 / ratio)


@pytest.mark.parametrize("ratio", RATIOS)
def test_a_driven_rod_takes_a_heavy_mass_along_from_the_start(ratio, tmp_path):
    spec = _pendulum(tmp_path, ratio, "drive = { polynomial = [0.0, 2.0] }\n")
    ready = prepare(spec.mechanism, spec.packages)
    v = ready.y0[ready.model.n_pos :]
    np.testing.assert_allclose(v[6:9], [0.0, 2.0, 0.0], atol=1e-12)  # the mass
    np.testing.assert_allclose(v[[1, 5]], [1.0, 2.0], atol=1e-12)  # the rod


@pytest.mark.parametrize("ratio", [1.0, *RATIOS])
@pytest.mark.parametrize("light", [0, 1])
def test_a_loop_with_redundant_rows_starts(ratio, light):
    """A parallelogram of hinges, one crank given its spin; a coupler or two cranks are heavy."""
    rods = Rods(core=0.1)
    heavy = (1.0, ratio) if light == 0 else (ratio, 1.0)
    left = rods.rod((0, 0, 0), (0, 1, 0), heavy[0])
    coupler = rods.rod((0, 1, 0), (2, 1, 0), heavy[1])
    right = rods.rod((2, 1, 0), (2, 0, 0), heavy[0])
    rods.joint("A", "revolute", GROUND, left, (0, 0, 0))
    rods.joint("B", "revolute", left, coupler, (0, 1, 0))
    rods.joint("C", "revolute", coupler, right, (2, 1, 0))
    rods.joint("D", "revolute", GROUND, right, (2, 0, 0))
    sample = rods.sample((coupler, (1, 1, 0)), {left: (0, 0, -3.0)}, gravity_G=GRAVITY)
    y = consistent_state(sample.model, sample.start, sample.names)
    v = y[sample.model.n_pos :]
    np.testing.assert_allclose(v[6:12], [3.0, 0, 0, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(v[12:18], [1.5, 0, 0, 0, 0, -3.0], atol=1e-12)
    assert redundancy(sample.model, y, sample.names).count == 3


@pytest.mark.parametrize("ratio", RATIOS)
def test_a_heavy_mass_on_a_flexible_arm_vibrates(ratio, repository, tmp_path):
    """A cantilever without gravity, its heavy end given a velocity: v / w sin w t."""
    shipped, packages = repository / "tests/packages/double-pendulum-limits", tmp_path / "packages"
    packages.mkdir()
    shutil.copy(shipped / "arm.isotropic-paper.vtkhdf", packages / "arm.base.vtkhdf")
    case = (repository / "cases/double-pendulum-limits/case.toml").read_text()
    parts = [
        case[case.index(a) : case.index(b)]
        for a, b in (
            ("[materials.aluminium]", "[materials.graphite"),
            ("[sections.arm]", "[sections.hand]"),
            ("[bodies.arm]\nkind", "[bodies.hand]\nkind"),
        )
    ]
    mass, length, speed = 1.3 * ratio, 0.545, 1.0 / np.sqrt(ratio)
    load = rigid("load", mass, 1e-9 * mass, {"c": [0, 0, 0]}, position=[length, 0, 0])
    text = (
        "".join(parts).replace("elements", 'mass_form = "lumped"\nelements')
        + load
        + f"velocity = [0.0, {speed}, 0.0]\n"
        + "[ground.wall]\nposition = [0.0, 0.0, 0.0]\n"
        + '[joints.wall]\nkind = "fixed"\nbetween = ["ground.wall", "arm.root"]\n'
        + '[joints.end]\nkind = "spherical"\nbetween = ["arm.tip", "load.c"]\n'
        + '[signals.y]\nkind = "position"\nat = "load.c"\ncomponent = "y"\n'
    )
    solver = 't_end = {0}\noutput_step = {1}\nrtol = 1e-5\nmodes_at_start = "free"'
    spec = _spec(tmp_path, text, solver.format(1.0, 1.0), packages)
    package = spec.packages["arm"]
    tip = next(i for i in package.interfaces if i.name == "tip").phi_B[1]
    compliance = tip @ np.linalg.solve(package.stiffness, tip)
    w = 1.0 / np.sqrt(compliance * mass)
    t_end = 2.0 / w
    spec = spec.changed({"solver.t_end": t_end, "solver.output_step": t_end / 20})
    result, summary = execute(spec, progress=False)
    assert summary["completed"]
    assert summary["cost"]["steps"] < 10_000  # the modes of the arm ring 1e6 times as fast
    (y,) = (s.values for s in result.signals if s.name == "y")
    expected = speed / w * np.sin(w * result.t)
    np.testing.assert_allclose(y, expected, atol=2e-3 / w * speed, rtol=0)


@pytest.mark.parametrize(("mass", "integrator"), [(1e6, "radau"), (1e6, "rk8"), (1e9, "rk8")])
def test_a_mass_point_on_a_flexible_body_falls_freely(mass, integrator, repository, tmp_path):
    """The hand of the double pendulum (0.73 kg) cannot hold it: 9.81 t^2 / 2, links at rest."""
    runs = case_runs(repository, "double-pendulum-limits", tmp_path)
    spec = read_run(runs / "layup-2-linear.json").changed(
        {
            "masses.M2.mass": mass,
            "joints.shoulder.drive": None,
            "bodies.arm.angular_velocity": [0.0, 0.0, 0.0],
            "solver.t_end": 0.2,
            "solver.output_step": 0.01,
            "solver.integrator": integrator,
            "solver.rtol": 1e-4,
            "solver.on_invalid": "warn",
        }
    )
    result, summary = execute(spec, progress=False)
    assert summary["completed"]
    tip = next(s.values for s in result.signals if s.name == "tip_y")
    np.testing.assert_allclose(tip, -0.5 * G * result.t**2, atol=2e-5)
