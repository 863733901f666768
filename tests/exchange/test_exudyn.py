"""Package to Exudyn: its matrices from our invariants, and the same motion in both."""

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.exchange_routes import PROGRAMS
from samples.exchange_samples import DIRECTIONS, bar, request

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.__main__ import main as exchange
from plymotion.solver.__main__ import main
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import ModalPackage, read_package, write_package
from plymotion.solver.results import read_result

T_END, STEPS = 0.02, 4000
CASE = """\
format = 1
title = "A bar that flies"
gravity = [0.0, 0.0, GRAVITY]

[bodies.arm]
kind = "package"
package = "arm.vtkhdf"
velocity = [0.0, 0.0, 0.0]
angular_velocity = SPIN
"""
SPIN = [3.0, 20.0, 10.0]


@pytest.fixture(scope="module")
def exudyn() -> Any:
    """Exudyn from the folder of the tests' programs."""
    if not (PROGRAMS / "python" / "exudyn").is_dir():
        pytest.skip("exudyn is not installed: make test-exchange downloads it")
    sys.path.insert(0, str(PROGRAMS / "python"))
    try:
        import exudyn
    finally:
        sys.path.pop(0)
    return exudyn


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exudyn")
    body = bar()
    modes = [
        {"kind": "lowest", "count": 4},
        {"kind": "attachment", "at": "tip", "directions": DIRECTIONS[:3]},
    ]
    package = from_matrices(body.M, body.K, body.nodes, body.dofs, **request(modes=modes))
    write_package(folder / "arm.vtkhdf", package)
    out = str(folder / "arm_exudyn.py")
    assert exchange(["export", str(folder / "arm.vtkhdf"), "--to", "exudyn", "-o", out]) == 0
    return folder


@pytest.fixture(scope="module")
def package(folder: Path) -> ModalPackage:
    return read_package(folder / "arm.vtkhdf")


def script(folder: Path) -> Any:
    """The written script, imported."""
    spec = importlib.util.spec_from_file_location("arm_exudyn", folder / "arm_exudyn.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_matrices_equal_exudyns_own_integrals(
    exudyn: Any, folder: Path, package: ModalPackage
) -> None:
    """Exudyn computes them from the full mass matrix and the shapes at the nodes."""
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    body = bar()
    n = len(body.nodes)
    fem = FEMinterface()
    fem.nodes = {"Position": body.nodes}
    fem.massMatrix, fem.stiffnessMatrix = body.M, body.K
    basis = package.shapes_B[:, :n, :3].reshape(package.n_mode, -1).T
    fem.modeBasis = {"matrix": basis, "type": "NormalModes"}
    own = ObjectFFRFreducedOrderInterface(fem).GetDictionary()
    found = script(folder)
    data = found.exudyn_data(found.read())
    compared = [name for name in data if name[0] in "mMc" or name in ("inertiaLocal", "totalMass")]
    compared = [name for name in compared if name != "modeBasis"]
    assert len(compared) == 12
    sizes = {"mPsiTildePsi": "massMatrixReduced", "mPhitTPsiTilde": "mPhitTPsi"}
    for name in compared:
        exact, mine = np.asarray(own[name]), np.asarray(data[name])
        size = np.abs(np.asarray(own[sizes.get(name, name)])).max()
        assert np.abs(mine - exact).max() < 1e-10 * size, name


@pytest.mark.parametrize("gravity", [0.0, -9.81])
def test_motion_is_the_same(
    exudyn: Any, folder: Path, package: ModalPackage, gravity: float, tmp_path: Path
) -> None:
    """A bar thrown with spin, with and without weight: path of its tip."""
    mine = our_path(folder, tmp_path, gravity)
    theirs = exudyn_path(exudyn, script(folder), gravity)
    assert np.abs(mine - theirs).max() < 1e-6
    bend = np.abs(mine[-1] - mine[0]).max()
    assert bend > 0.05  # it moves far


def our_path(folder: Path, out: Path, gravity: float, joints: str = "", spin: Any = SPIN) -> Array:
    """Tip (k, 3) every millisecond by radau."""
    lines = [CASE.replace("GRAVITY", str(gravity)).replace("SPIN", str(spin)), joints]
    lines += [f'[signals.{c}]\nkind = "position"\nat = "arm.tip"\ncomponent = "{c}"' for c in "xyz"]
    lines += [
        f'[solver]\nt_end = {T_END}\noutput_step = 1e-3\nintegrator = "radau"\nrtol = 1e-9',
        "[runs.base]",
    ]
    case = folder / f"case{abs(gravity):g}{len(joints)}.toml"
    case.write_text("\n".join(lines) + "\n")
    assert main(["check", str(case), "--out", str(out)]) == 0
    assert main(["run", str(out / "runs" / "base.json"), "--quiet"]) == 0
    result = read_result(out / "base" / "result.vtkhdf")
    return np.column_stack([signal.values for signal in result.signals])


def exudyn_path(
    exudyn: Any, body_script: Any, gravity: float, spin: Any = SPIN, joint: Any = None
) -> Array:
    """The same by Exudyn's generalized-alpha with small steps."""
    from exudyn.itemInterface import SensorMarker

    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    body = body_script.add_body(mbs, positionRef=[0, 0, 0], initialAngularVelocity=spin)
    if gravity:
        body_script.add_weight(mbs, body, [0.0, 0.0, gravity])
    if joint is not None:
        joint(mbs, body_script, body)
    marker = body_script.add_marker(mbs, body, "tip")
    sensor = mbs.AddSensor(
        SensorMarker(
            markerNumber=marker,
            storeInternal=True,
            outputVariableType=exudyn.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime = T_END
    settings.timeIntegration.numberOfSteps = STEPS
    settings.timeIntegration.generalizedAlpha.spectralRadius = 1.0
    settings.solution.sensors.writePeriod = 1e-3
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.relativeTolerance = 1e-10
    mbs.SolveDynamic(settings)
    return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:]


def test_a_hinged_link_is_the_same(exudyn: Any, folder: Path, tmp_path: Path) -> None:
    """A link on a hinge, with markers of rotation, falls in both codes along one path."""
    from exudyn.itemInterface import GenericJoint, MarkerBodyRigid, ObjectGround

    hinge = (
        "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
        '[joints.hinge]\nkind = "revolute"\nbetween = ["ground.O", "arm.root"]\naxis = [0, 1, 0]\n'
    )
    spin = [0.0, 20.0, 0.0]
    mine = our_path(folder, tmp_path, -9.81, hinge, spin)

    def joint(mbs: Any, body_script: Any, body: dict[str, Any]) -> None:
        ground = mbs.AddMarker(MarkerBodyRigid(bodyNumber=mbs.AddObject(ObjectGround())))
        root = body_script.add_marker(mbs, body, "root")
        axes = [1, 1, 1, 1, 0, 1]
        mbs.AddObject(GenericJoint(markerNumbers=[ground, root], constrainedAxes=axes))

    theirs = exudyn_path(exudyn, script(folder), -9.81, spin, joint)
    assert np.abs(mine[-1] - mine[0]).max() > 0.05
    assert np.abs(mine - theirs).max() < 1e-6
