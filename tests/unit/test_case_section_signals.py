"""Signals of resultants and ply stresses: those of the package, in place and along the beam."""

import numpy as np
import pytest
from peers.ply_stresses import beam_ply_stress
from samples.case_samples import HEAD, SOLVER

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.signals import PlyStressSignal, ResultantSignal
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.mechanism.build import build
from plymotion.solver.run.execution import read_run
from plymotion.solver.signals import Recording, sensors
from plymotion.solver.strength.weakest_plies import resultants

TEXT = """
[bodies.arm]
kind = "package"
package = "{package}"
"""


@pytest.fixture(scope="module")
def arm(repository, tmp_path_factory):
    """A free arm of the double pendulum, one ply of graphite/epoxy at 30 degrees."""
    folder = tmp_path_factory.mktemp("arm")
    package = repository / "tests/packages/double-pendulum-limits/arm.layup-2-linear.vtkhdf"
    file = folder / "case.toml"
    file.write_text(
        HEAD + TEXT.format(package=package) + SOLVER.format(t_end=1.0, step=1.0, more="")
    )
    write_case(load_case(file), folder / "build")
    spec = read_run(folder / "build/runs/base.json")
    built = build(spec.mechanism, spec.packages)
    rng = np.random.default_rng(4)
    y = rng.normal(size=(5, built.model.n_pos + built.model.n_vel + 1))
    return built, spec.packages["arm"], Recording(built.model, np.arange(5.0), y)


def _values(arm, **table):
    built, _, recording = arm
    kind = {"resultant": ResultantSignal, "ply_stress": PlyStressSignal}[table["kind"]]
    signal = kind.model_validate({"body": "arm", **table})
    return sensors(built, {"signal": signal})["signal"].values(recording)


def test_resultants_at_and_between_stations(arm):
    _, package, recording = arm
    F = resultants(package, recording.modes(0))
    x = package.recovery.station_x
    for k in (0, 3, len(x) - 1):
        found = _values(arm, kind="resultant", x=float(x[k]), component="M3")
        np.testing.assert_allclose(found, F[k, 5], rtol=1e-12)
    middle = 0.25 * x[3] + 0.75 * x[4]
    found = _values(arm, kind="resultant", x=float(middle), component="F2")
    np.testing.assert_allclose(found, 0.25 * F[3, 1] + 0.75 * F[4, 1], rtol=1e-9)


def test_stress_of_a_point_and_the_worst_of_a_ply(arm):
    _, package, recording = arm
    recovery = package.sections[0].recovery
    stress = beam_ply_stress(package, 3, recording.modes(0))[:, :, 0]  # along the fibre
    x = float(package.recovery.station_x[3])
    table = {"kind": "ply_stress", "x": x, "region": None, "ply": 0, "component": "11"}
    point = recovery.points[7]
    near = [float(point[0]) + 1e-9, float(point[1])]
    np.testing.assert_allclose(_values(arm, **table, point=near), stress[:, 7], rtol=1e-9)
    worst = np.abs(stress).max(axis=0).argmax()
    np.testing.assert_allclose(_values(arm, **table, point=None), stress[:, worst], rtol=1e-9)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"kind": "resultant", "x": 9.0, "component": "F1"}, r"signals\.signal\.x = 9: expected 0"),
        ({"kind": "ply_stress", "x": 0.1, "region": "sektion", "ply": 0, "component": "11",
          "point": None}, r'region = "sektion": no such region; did you mean'),
        ({"kind": "ply_stress", "x": 0.1, "region": None, "ply": 6, "component": "11",
          "point": None}, r"signals\.signal\.ply = 6: expected 0 to 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_measured_is_said_before_the_run(arm, table, message):
    with pytest.raises(InputError, match=message):
        _values(arm, **table)
