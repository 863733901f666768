"""Package to MuJoCo: the chain of virtual joints, its frequencies and a vibration there."""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.beam_samples import reduced
from samples.body_specs import CLAMPED
from samples.exchange_routes import PROGRAMS
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from plymotion.preprocess.exchange.formats.mujoco import write
from plymotion.solver.__main__ import main
from plymotion.solver.package import read_package

SHANK = "hopper/shank.jump.vtkhdf"


@pytest.fixture(scope="module")
def mujoco() -> Iterator[Any]:
    """MuJoCo from the folder of the tests' programs."""
    if not (PROGRAMS / "python" / "mujoco").is_dir():
        pytest.skip("mujoco is not installed: make test-exchange downloads it")
    sys.path.insert(0, str(PROGRAMS / "python"))
    try:
        import mujoco

        yield mujoco
    finally:
        sys.path.remove(str(PROGRAMS / "python"))


def exported(repository: Path, name: str, folder: Path) -> Path:
    """The model of a shipped package."""
    file = repository / "tests/packages" / name
    write(read_package(file), folder / "model.xml", file)
    return folder / "model.xml"


@pytest.mark.parametrize(
    "name",
    [
        "robot-import/forearm.tubes.vtkhdf",
        "actuated-beam/beam.layup-1.vtkhdf",  # bending and torsion are coupled
        "rotor-blade/blade.stiffened.vtkhdf",  # tapered, pretwisted
        "double-pendulum-shell/arm.shell.vtkhdf",  # nodes of a shell
        SHANK,
    ],
)
def test_lowest_frequencies_and_the_body_at_rest(
    mujoco: Any, repository: Path, tmp_path: Path, name: str
) -> None:
    """MuJoCo's own mass matrix and springs: 1 %; mass, mass centre and places of the body."""
    model = mujoco.MjModel.from_xml_path(str(exported(repository, name, tmp_path)))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    w = np.sqrt(eigh(np.diag(model.jnt_stiffness.ravel()), M, eigvals_only=True))[:3]
    package = read_package(repository / "tests/packages" / name)
    own = np.sqrt(eigh(package.stiffness, package.mass, eigvals_only=True))[:3]
    assert w == pytest.approx(own, rel=0.01)
    total = package.node_mass.sum()
    assert model.body_mass.sum() == pytest.approx(total, rel=1e-9)
    assert total == pytest.approx(package.invariants.mass, rel=1e-3)
    centre = package.node_mass @ package.nodes_B / total
    size = np.ptp(package.nodes_B)
    assert data.subtree_com[0] == pytest.approx(centre, abs=1e-9 * size)
    for interface in package.interfaces:
        site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, interface.name)
        assert data.site_xpos[site] == pytest.approx(interface.position_B, abs=1e-9 * size)
        assert data.site_xmat[site] == pytest.approx(interface.A_BI.ravel(), abs=1e-9)


@pytest.mark.parametrize(
    ("name", "at"), [("robot-import/forearm.tubes", "roll"), ("exchange/arm.shell", "tip")]
)
def test_moments_turn_the_end_as_that_of_the_body(
    mujoco: Any, repository: Path, tmp_path: Path, name: str, at: str
) -> None:
    """What a second link does to the first; the lowest frequencies do not show torsion."""
    model = mujoco.MjModel.from_xml_path(str(exported(repository, f"{name}.vtkhdf", tmp_path)))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    J = np.zeros((2, 3, model.nv))
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, at)
    mujoco.mj_jacSite(model, data, *J, site)
    package = read_package(repository / f"tests/packages/{name}.vtkhdf")
    place = next(i for i in package.interfaces if i.name == at)
    for ways, shapes, error in ((J[1], place.psi_B, 1e-3), (J[0][1:], place.phi_B[1:], 0.02)):
        own = np.diag(shapes @ np.linalg.solve(package.stiffness, shapes.T))
        there = np.diag(ways / model.jnt_stiffness.ravel() @ ways.T)
        assert there == pytest.approx(own, rel=error)


@pytest.mark.parametrize(("first", "last"), [(30.0, 30.0), (90.0, 30.0)])
def test_a_section_with_turned_axes_bends_along_them(
    mujoco: Any, tmp_path: Path, first: float, last: float
) -> None:
    """Compliance of the tip and directions of the modes, with bending that is coupled to torsion.

    Frequencies alone do not show that a chain bends in the wrong planes.
    """
    K = np.diag([1e6, 3e5, 3e5, 6.0, 4.0, 40.0])
    K[3, 4] = K[4, 3] = 2.0
    angle = np.radians(np.linspace(first, last, 16))
    line = {
        "nodes": np.outer(np.linspace(0.0, 1.0, 17), [1.0, 0.0, 0.0]).tolist(),
        "x2_axes": np.stack([0.0 * angle, np.cos(angle), np.sin(angle)], axis=1).tolist(),
    }
    modes = [{"kind": "lowest", "count": 6}, {"kind": "attachment", "at": "tip"}]
    mass = np.diag([0.5, 0.5, 0.5, 1e-4, 4e-5, 6e-5])
    package = reduced(CLAMPED, modes, elements=16, K=K, mass=mass, line=line).package
    turned = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    package = replace(package, interfaces=[replace(i, A_BI=turned) for i in package.interfaces])
    write(package, tmp_path / "model.xml", tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "tip")
    assert data.site_xmat[site] == pytest.approx(turned.ravel(), abs=1e-9)
    J, _turns = np.zeros((2, 3, model.nv))
    mujoco.mj_jacSite(model, data, J, _turns, site)
    phi = next(i.phi_B for i in package.interfaces if i.name == "tip")
    own = phi @ np.linalg.solve(package.stiffness, phi.T)
    there = J / model.jnt_stiffness @ J.T
    assert there[1:, 1:] == pytest.approx(own[1:, 1:], abs=0.01 * np.abs(own).max())
    ways = J @ eigh(np.diag(model.jnt_stiffness.ravel()), M)[1][:, :2]
    expected = phi @ eigh(package.stiffness, package.mass)[1][:, :2]
    size = np.linalg.norm(ways, axis=0) * np.linalg.norm(expected, axis=0)
    assert np.abs((ways * expected).sum(axis=0)) / size == pytest.approx(1.0, abs=1e-4)


def test_a_vibration_in_mujoco(mujoco: Any, repository: Path, tmp_path: Path) -> None:
    """Let go in its first mode, the shank swings at the frequency of the body, and loses energy."""
    model = mujoco.MjModel.from_xml_path(str(exported(repository, SHANK, tmp_path)))
    data = mujoco.MjData(model)
    package = read_package(repository / "tests/packages" / SHANK)
    model.opt.gravity[:] = 0.0
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    _, shapes = eigh(np.diag(model.jnt_stiffness.ravel()), M)
    data.qpos[:] = 1e-3 * shapes[:, 0] / np.abs(shapes[:, 0]).max()
    own, swing, t = float(package.frequencies[0]), [], []
    step = 10 * model.opt.timestep  # of the file
    for _ in range(int(3.1 * 2.0 * np.pi / own / step)):
        mujoco.mj_step(model, data, 10)
        t.append(data.time)
        swing.append(float(shapes[:, 0] @ M @ data.qpos))
    x = np.array(swing)
    k = np.flatnonzero((x[1:] < 0.0) & (x[:-1] >= 0.0))
    crossings = np.array(t)[k] + step * x[k] / (x[k] - x[k + 1])
    period = float(np.diff(crossings).mean())
    assert len(crossings) == 3
    assert 2.0 * np.pi / period == pytest.approx(own, rel=0.01)
    ratio = package.damping[0, 0] / (2.0 * own * package.mass[0, 0])
    decay = np.log(x[0] / x[k[-1] + int(0.75 * period / step) :].max()) / (3.0 * 2.0 * np.pi)
    assert decay == pytest.approx(ratio, rel=0.1)


def test_what_is_no_chain_is_refused(
    repository: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = repository / "tests/packages/slider-crank/rod.steel.vtkhdf"
    assert main(["export", str(file), "--to", "mujoco", "-o", str(tmp_path / "a.xml")]) == 2
    assert "reference_condition = 'chord': expected a body whose frame is clamped" in (
        capfd.readouterr().err
    )
    assert not list(tmp_path.iterdir())
