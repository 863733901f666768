"""The double pendulum whose hand is a shell, from the shipped packages, beside the one of beams."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.flexible_samples import momenta, simulate, total_energy

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import flexible_body
from plymotion.solver.package import read_package, validate
from plymotion.solver.run.execution import execute, read_run

CASE = "cases/double-pendulum-shell/case.toml"
SHIPPED = "tests/packages/double-pendulum-shell"
T_END = 0.2


@pytest.fixture(scope="module")
def build(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A build folder of the case that uses the shipped packages."""
    folder = tmp_path_factory.mktemp("double-pendulum-shell")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        write_case(load_case(repository / CASE), folder, repository / SHIPPED)
    return folder


@pytest.fixture(scope="module")
def runs(build: Path) -> dict[str, Any]:
    """Signals and summary of both runs, up to T_END."""
    found = {}
    for name in ("shell", "beam"):
        spec = read_run(build / f"runs/{name}.json").changed({"solver.t_end": T_END})
        result, summary = execute(spec, progress=False)
        found[name] = ({s.name: s.values for s in result.signals}, summary)
    return found


def test_tip_moves_as_that_of_the_beam(runs: dict[str, Any]) -> None:
    tips = [np.column_stack([s["tip_x"], s["tip_y"]]) for s, _ in runs.values()]
    range_of_motion = np.ptp(tips[1], axis=0).max()
    assert range_of_motion > 1.0
    gap = np.linalg.norm(tips[0] - tips[1], axis=1).max()
    assert gap < 0.02 * range_of_motion
    assert gap < 1e-5  # the links are stiff: this is what the difference of 1 % in bending makes


def test_hand_bends_as_the_beam(runs: dict[str, Any]) -> None:
    """The largest deflection; vibrations of frequencies that differ by 0.4 % drift in phase."""
    one, two = (runs[name][0]["hand_mid"] for name in ("shell", "beam"))
    assert np.abs(one).max() == pytest.approx(np.abs(two).max(), rel=0.01)
    assert np.abs(one - two).max() < 0.05 * np.abs(two).max()


def test_only_stiffening_is_missing(runs: dict[str, Any]) -> None:
    """With second-order data, the loads of the beam have 0.21 of its stiffness."""
    for _, summary in runs.values():
        assert summary["completed"]
        assert [w["code"] for w in summary["warnings"]] == ["stiffening-matters"]
        assert 0.1 < summary["warnings"][0]["value"] < 0.21
        assert summary["checks"]["energy_drift_relative"] < 1e-6
        assert summary["checks"]["constraint_position_max"] < 1e-6


def test_strength_of_the_shell_is_told(runs: dict[str, Any]) -> None:
    """The hand bends in its plane: the outermost cells are the worst."""
    found = runs["shell"][1]["strength"]["hand"]
    assert found["criterion"] == "von-mises"
    assert found["ratio"] > 1.0
    assert found["ply"]["material"] == "aluminium"
    assert abs(found["point"][1] - 0.02) > 0.014  # in the outermost cells


def test_shipped_hand_is_sound_and_flies_freely(repository: Path) -> None:
    file = repository / SHIPPED / "hand.shell.vtkhdf"
    assert [f for f in validate(file) if f.level != "note"] == []
    package = read_package(file)
    model = assemble_model([flexible_body("hand", package)], [], [])
    m = package.n_mode
    y0 = np.zeros(model.n_pos + model.n_vel + 1)
    y0[3] = 1.0
    y0[7 : 7 + m] = [1e-3, -2e-4, 1e-5, 5e-6]
    y0[7 + m : 13 + m] = [0.3, -0.2, 0.5, 5.0, 3.0, 8.0]
    y = simulate(model, y0, np.linspace(0.0, 0.02, 5))
    energy = np.array([total_energy(model, state) for state in y])
    linear, angular = (np.array(part) for part in zip(*(momenta(model, s) for s in y), strict=True))
    assert np.abs(energy / energy[0] - 1).max() < 1e-8
    assert np.abs(linear - linear[0]).max() < 1e-8 * np.linalg.norm(linear[0])
    assert np.abs(angular - angular[0]).max() < 1e-8 * np.linalg.norm(angular[0])


def test_shipped_packages_are_those_of_the_case(build: Path) -> None:
    """Their inputs are the case's: `make ship` after a change of the bodies."""
    for run in (build / "runs").glob("*.json"):
        assert set(read_run(run).packages) == {"arm", "hand"}


def test_coarse_form_has_the_same_hand(repository: Path) -> None:
    case = load_case(repository / CASE, coarse=True)
    assert case.runs["shell"].solver.t_end == T_END
    assert (
        case.runs["shell"].bodies["hand"]
        == load_case(repository / CASE).runs["shell"].bodies["hand"]
    )


def test_shipped_hand_opens_in_pyvista(repository: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    file = repository / SHIPPED / "hand.shell.vtkhdf"
    grid, package = pyvista.read(file), read_package(file)
    assert (grid.n_points, grid.n_cells) == (len(package.nodes_B), len(package.cell_types))
    assert np.array_equal(grid.point_data["mode_002_shape"], package.shapes_B[1, :, :3])
