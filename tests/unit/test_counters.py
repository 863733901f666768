"""Counters of the compiled loops against what the method needs."""

from pathlib import Path

import pytest
from samples.case_samples import case_runs

from plymotion.solver.run.execution import execute, read_run


@pytest.fixture(scope="module")
def file(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return case_runs(repository, "double-pendulum", tmp_path_factory.mktemp("p")) / "layup-1.json"


def cost(file: Path, **keys: object) -> dict[str, int]:
    spec = read_run(file).changed({f"solver.{key}": value for key, value in keys.items()})
    _, summary = execute(spec.changed({"solver.t_end": 0.02}), progress=False)
    return dict(summary["cost"])


def test_radau_without_closing_of_joints(file: Path) -> None:
    """One matrix for each step that is tried, factorised for the real and the complex stages."""
    found = cost(file, constraints="index1", output_step=0.02)
    tried = found["steps"] + found["rejected"]
    assert found["rejected"] > 0
    assert found["jacobians"] == tried
    assert found["factorisations"] == 2 * tried
    # one at the start; three for each iteration, of which each step that is tried has one at least
    assert found["evaluations"] >= 1 + 3 * tried


def test_radau_closes_joints_after_steps(file: Path) -> None:
    """Each closing takes a matrix of its own, if no iteration of its positions needs more."""
    few = cost(file, output_step=0.02)
    tried, closed = (
        few["steps"] + few["rejected"],
        few["jacobians"] - few["steps"] - few["rejected"],
    )
    assert closed >= few["steps"]
    assert few["factorisations"] == 2 * tried + closed
    many = cost(file, output_step=1e-3)  # states between the steps are no part of them
    for name in ("steps", "evaluations", "jacobians", "factorisations"):
        assert many[name] == few[name]


def test_generalized_alpha_and_explicit(file: Path) -> None:
    alpha = cost(file, integrator="generalized-alpha", constraints="ggl")
    assert alpha["jacobians"] == alpha["factorisations"] == alpha["steps"] + alpha["rejected"]
    explicit = cost(file, integrator="rk8")
    assert explicit["jacobians"] == explicit["factorisations"] == 0
