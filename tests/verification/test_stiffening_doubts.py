"""Words on stiffened bodies that buckle, and the two ways of computing them."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, reduced
from samples.stiffening_samples import CHORD, rectangle, soft_modes, soft_pendulum

from plymotion.solver.checks.finished_run import FinishedRun
from plymotion.solver.checks.stability import (
    BucklingMonitor,
    Loading,
    SpinMonitor,
    geometric_stiffness,
)
from plymotion.solver.checks.statics import unjudged_hints
from plymotion.solver.checks.stiffening import stiffening_findings
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble, derivative
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.integrators.generic.drive import Solution
from plymotion.solver.mechanism.build import build

K, MASS = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
LENGTH = 0.5


HINGED = {
    "foot": {"kind": "revolute", "between": ["ground.foot", "column.root"]},
    "head": {
        "kind": "point_on_line",
        "between": ["ground.foot", "column.tip"],
        "axis": [1.0, 0.0, 0.0],
    },
}


def column(force: float, joints=None, others=0, **options):
    """A clamped column with a force along its axis at the tip, as a mechanism of a case."""
    modes = [{"kind": "bending-xy", "count": 3}]
    tip_load = {"kind": "attachment", "at": "tip", "directions": ["x", "y"]}
    package = reduced(CLAMPED, [*modes, tip_load], K=K, mass=MASS, length=LENGTH).package
    unit = np.eye(3).tolist()
    table = {
        "bodies": {"column": {"kind": "package", "package": "column.vtkhdf"}}
        | {f"free-{k}": {"kind": "rigid", "mass": 1.0, "inertia": unit} for k in range(others)},
        "ground": {"foot": {"position": [0.0] * 3}},
        "joints": joints or {"foot": {"kind": "fixed", "between": ["ground.foot", "column.root"]}},
        "forces": {
            "load": {
                "kind": "force",
                "at": "column.tip",
                "direction": [1.0, 0.0, 0.0],
                "law": {"constant": force},
            }
        },
        "solver": {"t_end": 1.0, "output_step": 1.0, **options},
    }
    return package, Mechanism.model_validate(table)


def found_codes(force: float, joints=None, others=0, **options):
    package, mechanism = column(force, joints, others, **options)
    built = build(mechanism, {"column": package})
    y = np.zeros((1, built.model.n_pos + built.model.n_vel + 1))
    y[0, built.model.pos_start + 3] = 1.0
    tip = next(i for i in package.interfaces if i.name == "tip")
    pressed = np.linalg.solve(package.stiffness, force * tip.phi_B[0])  # at rest under its load
    y[0, 7 : 7 + package.n_mode] = pressed
    rest = Solution(np.zeros(1), y, "finished", "")
    found = stiffening_findings(FinishedRun(mechanism, built, Treatment(), rest))
    return [finding.code for finding in found], built.model, y[0]


EULER = np.pi**2 * K[5, 5] / (4.0 * LENGTH**2)


@pytest.mark.parametrize("factor", [-3.0, 0.5, 0.99])
def test_a_column_below_eulers_load_stands(factor):
    codes, _, _ = found_codes(-factor * EULER, geometric_stiffening=True)
    assert codes == []


def test_a_column_above_eulers_load_buckles():
    codes, _, _ = found_codes(-1.01 * EULER, geometric_stiffening=True)
    assert codes == ["buckling-by-motion"]


@pytest.mark.parametrize("others", [0, 17])  # bodies, for more than 100 velocity coordinates
@pytest.mark.parametrize(("factor", "expected"), [(0.99, []), (1.01, ["buckling-by-motion"])])
def test_a_column_between_hinges_stands_up_to_four_times_that_load(factor, expected, others):
    """Its frame is clamped at one hinge, and its modes are those of the cantilever."""
    force = -4.0 * factor * EULER
    codes, model, y = found_codes(force, HINGED, others, geometric_stiffening=True)
    assert codes == expected
    monitor = BucklingMonitor(model, model, [0], SpinMonitor(model, ["column"]), 1.0)
    for t in ([0.0], [0.0, 0.001]):  # a second look in the pause of a large mechanism, too
        margin = monitor.margin(0, np.array(t), np.repeat(y[None], len(t), axis=0))
        assert ((margin > 0.0) == (not expected)).all()


def test_eulers_load_in_numbers():
    """Load at which the lowest eigenvalue vanishes, against pi^2 EI / 4 L^2 less shear."""
    _, model, y = found_codes(-EULER, geometric_stiffening=True)
    stiffness, _ = SpinMonitor(model, ["column"]).matrices(0, y)
    Kg = geometric_stiffness(model, model, 0, np.zeros(1), y[None])[0]
    largest = np.linalg.eigvals(np.linalg.solve(stiffness, -Kg)).real.max()
    np.testing.assert_allclose(largest, 1.0, rtol=1e-3)


def test_states_are_solved_once_for_all_bodies():
    """Rates and loads of the same states are the same arrays; of others they are their own."""
    _, model, y = found_codes(-0.5 * EULER, geometric_stiffening=True)
    loading, t = Loading(model), np.array([0.0, 1.0])
    both = np.stack([y, y])
    first = loading(t, both)
    assert loading(t, both) is first
    found = geometric_stiffness(model, model, 0, t, both, first)
    np.testing.assert_array_equal(found, geometric_stiffness(model, model, 0, t, both))
    for k in range(20):
        loading(np.array([2.0 + k]), y[None])
        loading(t, both)
    assert loading(t, both) is first


@pytest.mark.parametrize(("factor", "expected"), [(0.04, []), (0.06, ["stiffening-matters"])])
def test_a_linear_body_is_told_from_a_twentieth_on(factor, expected):
    assert found_codes(factor * EULER)[0] == expected


@pytest.mark.parametrize(
    ("axis", "share", "expected"),
    [(1, 0.04, []), (2, 0.06, ["stiffening-matters"]), (0, 4.0, [])],  # 0: about itself
)
def test_a_spinning_body_without_second_order_data_is_told_too(axis, share, expected):
    package, mechanism = column(0.0)
    package = replace(package, second_order=None)
    built = build(mechanism, {"column": package})
    model = built.model
    y = np.zeros((1, model.n_pos + model.n_vel + 1))
    y[0, 3] = 1.0
    slowest = SpinMonitor(model, ["column"]).safe_spin[0]
    assert slowest == pytest.approx(3.516 * np.sqrt(K[5, 5] / MASS[0, 0]) / LENGTH**2, rel=0.01)
    y[0, model.n_pos + 3 + axis] = np.sqrt(share) * slowest
    rest = Solution(np.zeros(1), y, "finished", "")
    run = FinishedRun(mechanism, built, Treatment(), rest)
    found = list(stiffening_findings(run))
    assert [finding.code for finding in found] == expected
    assert (
        "not judged: whether moments and forces across stiffen or buckle column"
        in unjudged_hints(run)[0]
    )
    assert [finding.value for finding in found] == pytest.approx([share] * len(expected), rel=0.01)


@pytest.mark.parametrize(("factor", "expected"), [(0.04, []), (-0.06, ["stiffening-matters"])])
def test_forces_along_a_body_without_second_order_data_are_estimated(factor, expected):
    package, mechanism = column(factor * EULER)
    package = replace(package, second_order=None)
    built = build(mechanism, {"column": package})
    y = np.zeros((1, built.model.n_pos + built.model.n_vel + 1))
    y[0, 3] = 1.0
    tip = next(i for i in package.interfaces if i.name == "tip")
    y[0, 7 : 7 + package.n_mode] = np.linalg.solve(package.stiffness, factor * EULER * tip.phi_B[0])
    run = FinishedRun(mechanism, built, Treatment(), Solution(np.zeros(1), y, "finished", ""))
    found = list(stiffening_findings(run))
    assert [finding.code for finding in found] == expected
    assert [finding.value for finding in found] == pytest.approx([0.06] * len(expected), rel=0.03)


STATE = """
import sys
import numpy as np
sys.path[:0] = {path!r}
from samples.stiffening_samples import CHORD, soft_modes, soft_pendulum
from plymotion.solver.math.compiled import COMPILED
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.evaluation.accelerations import derivative
assert COMPILED == {compiled}
pendulum = soft_pendulum(CHORD, soft_modes(2, axial=True), elements=8)
y = pendulum.y0 + 0.01 * np.random.default_rng(0).normal(size=pendulum.y0.size)
equations = assemble(pendulum.model, 0.1, y)
parts = [derivative(pendulum.model, 0.1, y), equations.M.ravel(), equations.f, equations.gamma,
         energies(pendulum.model, equations, y)]
np.save(sys.argv[1], np.concatenate([part / np.abs(part).max() for part in parts]))
"""


def test_compiled_code_and_plain_numpy_agree_to_rounding(tmp_path, repository):
    pytest.importorskip("numba")

    found = []
    for compiled in ("0", "1"):
        code = STATE.format(path=[str(repository / "tests")], compiled=compiled == "1")
        file = tmp_path / f"{compiled}.npy"
        environment = {**os.environ, "PLYMOTION_COMPILED": compiled}
        subprocess.run([sys.executable, "-c", code, str(file)], check=True, env=environment)
        found.append(np.load(file))
    np.testing.assert_allclose(found[0], found[1], rtol=0.0, atol=1e-12)


def test_stiffened_pendulum_moves_otherwise_than_a_linear_one():
    pendulum = soft_pendulum(CHORD, soft_modes(2), elements=8)
    model = pendulum.model
    y = pendulum.y0.copy()
    a = model.pos_start[1] + 7
    y[a] = 0.02
    rate = derivative(model, 0.0, y)
    linear = model._replace(
        second_start=np.zeros_like(model.second_start),
        marker_second=np.full_like(model.marker_second, -1),
    )
    assert np.abs(rate - derivative(linear, 0.0, y)).max() > 1.0
    assert np.abs(assemble(model, 0.0, y).M - assemble(linear, 0.0, y).M).max() > 1e-6
