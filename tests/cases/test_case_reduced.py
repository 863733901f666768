"""`rigid` and `reduced` of a body: a run with other modes takes the same package."""

from dataclasses import replace

import numpy as np
import pytest

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package.body.selection import rigid
from plymotion.solver.run.execution import execute, read_run


@pytest.fixture(scope="module")
def spec(repository, tmp_path_factory):
    out = tmp_path_factory.mktemp("pendulum")
    case = load_case(repository / "cases/double-pendulum/case.toml", sweeps=())
    write_case(case, out, repository / "tests/packages/double-pendulum")
    found = read_run(out / "runs/isotropic.json")
    return found.changed({"solver.t_end": 0.1, "solver.rtol": 1e-7})


def signals(run):
    result, summary = execute(run, progress=False)
    return np.array([s.values for s in result.signals]), summary


def test_rigid_bodies_have_the_mass_and_inertia_of_their_packages(spec):
    values, summary = signals(spec.changed({"bodies.arm.rigid": True, "bodies.hand.rigid": True}))
    assert summary["checks"]["modes_used"] == {"arm": 0, "hand": 0}
    assert summary["checks"]["energy_drift_relative"] < 1e-6
    by_hand, _ = signals(replace(spec, packages={n: rigid(p) for n, p in spec.packages.items()}))
    np.testing.assert_array_equal(values, by_hand)
    flexible, _ = signals(spec)
    names = list(spec.mechanism.signals)
    tip = [names.index("tip_x"), names.index("tip_y")]
    gap = np.abs(values[tip] - flexible[tip]).max()
    assert 1e-6 < gap < 1e-2
    assert not values[names.index("arm_mid")].any()


def test_fewer_modes_are_those_of_the_package(spec):
    one, two = ({"kind": "bending-xy", "count": count} for count in (1, 2))
    ends = [{"kind": "attachment", "at": "root", "directions": ["rz"]}]
    ends += [{"kind": "attachment", "at": "tip", "directions": ["x", "rz"]}]
    whole, _ = signals(spec)
    all_modes = [two, *ends]
    same, _ = signals(
        spec.changed({"bodies.arm.reduced": all_modes, "bodies.hand.reduced": all_modes})
    )
    np.testing.assert_allclose(same, whole, atol=1e-9)
    few, summary = signals(spec.changed({"bodies.arm.reduced": [one, *ends]}))
    assert summary["checks"]["modes_used"] == {"arm": 4, "hand": 5}
    assert 1e-9 < np.abs(few - whole).max() < 1e-3
