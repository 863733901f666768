"""pm.plan: one model for many runs of an optimisation, checked at designs drawn at random."""

import warnings

import numpy as np
import pytest
from samples.fidelity_packages import CASE, build_bodies
from scipy.optimize import minimize_scalar

import plymotion as pm
from plymotion.solver.__main__ import main

MASS = "masses.load.mass"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A case with its packages."""
    root = tmp_path_factory.mktemp("optimisation")
    (root / "case.toml").write_text(CASE)
    assert main(["check", str(root / "case.toml"), "--out", str(root / "build")]) == 0
    ready = root / "packages"
    ready.mkdir()
    build_bodies(root / "build/bodies", ready)
    return root


def planned(folder, changes=None, **options):
    case = pm.load(folder / "case.toml").changed(changes or {})
    out, ready = folder / "build", folder / "packages"
    return pm.plan(case, "base", out=out, packages=ready, **options)


@pytest.fixture(scope="module")
def plan(folder):
    return planned(folder, checked=0.0)


def test_an_optimum_by_the_plan_is_that_of_the_delivered_runs(folder, plan):
    """The mass with which the tip swings to a given height: one model, then the check."""
    assert plan.met
    assert 0.0 < plan.estimate["tip"] < 1e-2
    aim = float(np.ptp(plan.run({MASS: 1.7})["force"].values))

    def miss(mass):
        return (float(np.ptp(plan.run({MASS: mass})["force"].values)) / aim - 1.0) ** 2

    found = minimize_scalar(miss, bounds=(0.5, 3.0), method="bounded", options={"xatol": 1e-4})
    assert found.x == pytest.approx(1.7, abs=2e-3)
    assert not plan.checks  # none was asked for
    told = plan.check({MASS: found.x})
    assert told["met"]
    assert told["estimate"]["tip"] < 1e-2
    assert plan.checks == [told]


def test_a_run_of_the_plan_has_the_accuracy_of_the_delivered_run(folder, plan):
    case = pm.load(folder / "case.toml").changed({MASS: 1.5})
    delivered = pm.run(case, "base", out=folder / "delivered", packages=folder / "packages")
    tip, exact = plan.run({MASS: 1.5})["tip"].values, delivered.signals["tip"].values
    assert 0.0 < np.abs(tip - exact).max() < 1e-2 * np.abs(exact).max()


def test_a_share_of_the_designs_is_checked_and_always_the_same(folder):
    masses = np.linspace(0.6, 1.4, 12)
    drawn = []
    for _ in range(2):
        again = planned(folder, checked=0.3)
        for mass in masses:
            again.run({MASS: mass})
        drawn.append([found["changes"][MASS] for found in again.checks])
    assert drawn[0] == drawn[1]
    assert 1 <= len(drawn[0]) <= 8


@pytest.mark.provokes("plan-too-coarse")
def test_a_design_that_leaves_the_plan_is_told(folder):
    """With 1 kg the arm is as good as rigid, with 60 kg it is not."""
    rigid = planned(folder, checked=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rigid.run({MASS: 1.1})
    with pytest.warns(UserWarning, match="the plan does not reach .* 60") as told:
        rigid.run({MASS: 60.0})
    assert "plan-too-coarse" in str(told[0].message)
    near, far = rigid.checks
    assert near["met"]
    assert not far["met"]
    assert far["estimate"]["tip"] > 1e-2
    assert "differs" in far["reason"]


def test_what_is_wrong_is_told(folder, plan):
    with pytest.raises(pm.InputError, match=r"masses\.load\.mass = -1\.0"):
        plan.run({MASS: -1.0})
    with pytest.raises(pm.InputError, match="the case has no such key"):
        plan.run({"gravity.x": 1.0})
    with pytest.raises(pm.InputError, match="checked = 2: expected from 0 to 1"):
        planned(folder, checked=2)
    with pytest.raises(pm.InputError, match="has no run 'bse'; did you mean 'base'"):
        pm.plan(folder / "case.toml", "bse")
    case = pm.load(folder / "case.toml")
    case.fidelity = None
    del case.table["fidelity"], case.table["variants"], case.table["runs"]["impossible"]
    with pytest.raises(pm.InputError, match=r"run base: expected \[fidelity\]"):
        pm.plan(case, "base")
