"""N four-bar mechanisms through their singular positions: the exact branch, and only that."""

import subprocess
import sys

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case
from scipy.integrate import solve_ivp

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case

REFERENCE = "a02_n_four_bar"


@pytest.fixture(scope="module")
def runs(repository, tmp_path_factory):
    return case_runs(repository, "n-four-bar", tmp_path_factory.mktemp("build"))


@pytest.mark.parametrize("name", ["n-2", "n-2-hinges"])
def test_two_loops_for_ten_seconds(name, runs, reference):
    """Ten singular passes; redundant hinges move like independent ones."""
    t, s, summary = run_case(runs / f"{name}.json")
    found = np.array([s["x"], s["y"]]).T
    assert summary["completed"]
    for at, expected in ((4.0, "at_4"), (10.0, "exact"), (10.0, "published")):
        error = np.linalg.norm(found[np.searchsorted(t, at)] - reference["n-2"][expected])
        assert error < reference["tolerance"], (at, expected)
    drift = summary["checks"]["energy_drift_relative"]
    assert drift * 50.0 < reference["energy_tolerance"]  # 50 J in play
    assert summary["checks"]["degrees_of_freedom"] == 1


def _uprights(n, t):
    """Turn from the horizontal of n + 1 uprights that stay parallel [rad]: one equation."""
    pull = 9.81 * (3 * (n + 1) + 6 * n) / (2 * (n + 1) + 6 * n)
    exact = solve_ivp(
        lambda _, z: [z[1], -pull * np.cos(z[0])],
        (0.0, t[-1]),
        [np.pi / 2, -1.0],
        method="DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-13,
    )
    return exact.y[0]


@pytest.mark.parametrize(("integrator", "bound"), [("rk8", 1e-7), ("radau", 1e-6)])
def test_singular_passes_keep_what_rtol_asks_for(integrator, bound, runs):
    """What is left of Phi is amplified at each pass: 1e-12 m of it gave 6e-5 m at the end."""
    t, s, _ = run_case(runs / "n-2.json", integrator=integrator, rtol=1e-8)
    np.testing.assert_allclose(s["x"], np.cos(_uprights(2, t)), rtol=0.0, atol=bound)


def _generated(repository, folder, *words):
    """The run folder of a case that the generator writes."""
    command = [sys.executable, str(repository / "cases/n-four-bar/generate.py"), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (folder / "case.toml").write_text(done.stdout)
    write_case(load_case(folder / "case.toml"), folder / "build")
    return folder / "build/runs"


def test_many_loops_pass_their_first_singular_position(repository, tmp_path):
    """Eight loops against the single equation of parallel uprights."""
    n = 8
    runs = _generated(repository, tmp_path, "four-bars", str(n))
    t, s, summary = run_case(runs / f"n-{n}.json", t_end=0.9)
    assert summary["completed"]
    turn = _uprights(n, t)
    assert s["y"].min() < -0.5  # beyond the horizontal
    np.testing.assert_allclose(s["x"], np.cos(turn), atol=1e-5)
    np.testing.assert_allclose(s["y"], np.sin(turn), atol=1e-5)


def test_forty_loops_begin_as_their_equation_says(runs):
    _, s, summary = run_case(runs / "n-40.json", t_end=0.02)
    assert summary["checks"]["degrees_of_freedom"] == 1
    pull = 9.81 * (3 * 41 + 240) / (2 * 41 + 240)
    assert s["angle"][-1] == pytest.approx(-0.02 - pull * 0.02**3 / 6, abs=1e-7)


def test_the_case_is_what_its_generator_writes(repository):
    folder = repository / "cases/n-four-bar"
    command = [sys.executable, str(folder / "generate.py"), "four-bars", "2", "40"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == (folder / "case.toml").read_text()


def test_generated_chain_is_a_case(repository, tmp_path):
    """Three links let go level: they fall and keep their energy."""
    runs = _generated(repository, tmp_path, "chain", "3")
    _, s, summary = run_case(runs / "base.json", t_end=0.3)
    assert summary["checks"]["degrees_of_freedom"] == 3
    assert summary["checks"]["energy_drift_relative"] < 1e-6
    assert s["y"][-1] < -0.1
