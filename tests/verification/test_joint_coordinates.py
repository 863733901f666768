"""Mass matrix, bias and gravity forces in joint coordinates: recursive method, closed forms."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from peers.tree_dynamics import Tree

import plymotion as pm
from plymotion.solver.dynamics.analysis.joint_coordinates import JointCoordinates
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.model.model import state_size
from plymotion.solver.errors import InputError
from plymotion.solver.extras.robot.case import robot_case
from plymotion.solver.extras.robot.urdf import read_urdf
from plymotion.solver.mechanism.build import build
from plymotion.solver.mechanism.built_mechanism import BuiltMechanism

ROBOTS = Path(__file__).parents[1] / "samples/robots"
Found = tuple[JointCoordinates, BuiltMechanism]


def built(table: dict[str, object]) -> Found:
    """Return the joint coordinates of a mechanism without forces."""
    known = {k: v for k, v in table.items() if k not in ("format", "title", "runs", "forces")}
    model = build(pm.Case("robot", **known).check().runs["base"], {})
    offsets = {name: joint.shift for name, joint in model.joints.items()}
    return JointCoordinates(model.model, model.body_names, model.joint_names, offsets), model


@pytest.fixture
def robot() -> Callable[..., Found]:
    def made(name: str, **options: object) -> Found:
        robot = read_urdf(ROBOTS / f"{name}.urdf")
        return built(robot_case(robot, joints="free", **options).tables)  # type: ignore[arg-type]

    return made


@pytest.mark.parametrize("name", ["arm", "gripper", "shoulder"])
@pytest.mark.parametrize("keep_fixed", [False, True])
def test_the_recursive_method(robot: Callable[..., Found], name: str, keep_fixed: bool) -> None:
    """All kinds of joints, turned inertial frames, fixed joints merged or kept: equal to 1e-12."""
    ours, model = robot(name, keep_fixed=keep_fixed)
    tree, random = Tree(ROBOTS / f"{name}.urdf"), np.random.default_rng(3)
    assert sorted(ours.names) == sorted(tree.names)
    order = [ours.names.index(known) for known in tree.names]
    # joints that mimic others start at their offsets
    zero = np.array([{"jaw_2.z": -0.02, "thumb.angle": 0.3}.get(n, 0.0) for n in ours.names])
    for _ in range(10):
        q, v = random.uniform(-2.0, 2.0, (2, len(order)))
        y = ours.state(0.0, np.zeros(state_size(model.model)), q - zero, v)
        back, rates = ours.values(y)
        turned = np.array([not n.endswith(("z", "x", "y")) for n in ours.names])
        gap = np.where(turned, np.angle(np.exp(1j * (back - q + zero))), back - q + zero)
        assert np.abs(gap).max() < 1e-13
        assert np.abs(rates - v).max() < 1e-13
        found = ours.projected(0.0, y)
        M, c = tree.equations(q[order], v[order], np.array([0.0, 0.0, -9.81]))
        assert np.abs(found.M[np.ix_(order, order)] - M).max() < 1e-12 * np.abs(M).max()
        assert np.abs(found.c[order] - c).max() < 1e-12 * np.abs(c).max()


def test_a_free_base(robot: Callable[..., Found]) -> None:
    """A free root is three displacements and a rotation: mass, weight and energy of all links."""
    ours, model = robot("arm", base="free")
    assert ours.names[-6:] == [f"base.{k}" for k in ("x", "y", "z", "rx", "ry", "rz")]
    q, v = np.random.default_rng(4).uniform(-1.0, 1.0, (2, len(ours.names)))
    y = ours.state(0.0, np.zeros(state_size(model.model)), q, v)
    back, _ = ours.values(y)
    assert np.abs(back - q).max() < 1e-13
    found = ours.projected(0.0, y)
    mass = 2.0 + 2.5 + 0.8 + 0.4 + 0.15
    assert np.abs(found.M[3:6, 3:6] - mass * np.eye(3)).max() < 1e-13 * mass
    still = ours.projected(0.0, ours.state(0.0, y, q, 0.0 * v))
    assert np.abs(still.c[3:6] - [0.0, 0.0, 9.81 * mass]).max() < 1e-12 * mass
    kinetic = energies(model.model, assemble(model.model, 0.0, y), y)[0]
    assert abs(0.5 * v @ found.M @ v - kinetic) < 1e-13 * kinetic


def test_loops_and_joints_without_coordinates_are_refused() -> None:
    """A closed loop and a spherical joint have no joint coordinates here."""
    body = {
        "kind": "rigid",
        "mass": 1.0,
        "inertia": np.eye(3),
        "interfaces": {"a": {"position": [0, 0, 0]}, "b": {"position": [1, 0, 0]}},
    }
    case: dict[str, object] = {
        "bodies": {"one": body},
        "ground": {"a": {"position": [0, 0, 0]}, "b": {"position": [1, 0, 0]}},
        "joints": {
            "pin": {"kind": "revolute", "between": ["ground.a", "one.a"]},
            "lock": {"kind": "point_on_line", "between": ["ground.b", "one.b"], "axis": [1, 0, 0]},
        },
        "solver": {"t_end": 1.0, "output_step": 0.1},
    }
    with pytest.raises(InputError, match=r"joints\.lock.*(closes a loop|joint coordinates are)"):
        built(case)
    case["joints"] = {"ball": {"kind": "spherical", "between": ["ground.a", "one.a"]}}
    with pytest.raises(InputError, match=r'joints\.ball\.kind = "spherical": joint coordinates'):
        built(case)
