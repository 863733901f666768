"""Mechanisms of the solver's benchmarks, ready to integrate, with the point that is measured."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plymotion.solver.dynamics.bodies.marker import marker_motion
from plymotion.solver.dynamics.model import GROUND, Model
from plymotion.solver.dynamics.tables import JointTable, MarkerTable, assemble_model, flexible_body
from plymotion.solver.inputs.case import load_case
from plymotion.solver.inputs.case.load import merge
from plymotion.solver.inputs.case.resolved import resolved
from plymotion.solver.math.arrays import Array
from plymotion.solver.math.rotations import frame_from_axis
from plymotion.solver.mechanism import build
from plymotion.solver.mechanism.equilibrium import starting_state
from plymotion.solver.package import Interface, ModalPackage, read_package

SHIPPED = Path("tests/packages")
EIGHT = SHIPPED / "double-pendulum-8"  # 8 elements a link, lumped, 4 + 4 modes
GRAVITY = (0.0, -9.81, 0.0)


@dataclass(frozen=True)
class Problem:
    """A mechanism, its start, and where its error is measured."""

    name: str
    title: str
    model: Model
    y0: Array  # (n,)
    probe: int  # marker
    t_end: float  # [s]
    output_step: float  # [s]

    def places(self, y: Array) -> Array:
        """Global positions (k, 3) of the probe at states y (k, n) [m]."""
        return np.array([marker_motion(self.model, self.probe, state).x for state in y])


def interface(package: ModalPackage, name: str) -> Interface:
    """Interface of a package by its name."""
    return next(i for i in package.interfaces if i.name == name)


def from_case(
    case: Path,
    run: str,
    packages: Mapping[str, Path],
    probe: str,
    t_end: float,
    *,
    title: str = "",
    changes: Mapping[str, Any] | None = None,
) -> Problem:
    """Run of a case with the given packages, measured at the place of signal `probe`."""
    table = load_case(case).runs[run].model_dump()
    merge(table, dict(changes or {}))
    mechanism = resolved(table, f"{case}, run {run}")
    built = build(mechanism, {body: read_package(file) for body, file in packages.items()})
    start = mechanism.solver.start
    y0 = starting_state(built.model, built.start, start, built.joint_names, built.body_names)
    return Problem(
        case.parent.name, title, built.model, y0, built.signal_marker[probe], t_end, 0.01
    )


def double_pendulum(folder: Path = EIGHT, *, gravity: float = 9.81) -> Problem:
    """Run `isotropic` of the double pendulum, 1 s."""
    return from_case(
        Path("cases/double-pendulum/case.toml"),
        "isotropic",
        {body: folder / f"{body}.vtkhdf" for body in ("arm", "hand")},
        "tip_x",
        1.0,
        title="double pendulum, 8 elements a link, 4 + 4 modes, 1 s",
        changes={"gravity": [0.0, -gravity, 0.0]},
    )


def actuated_beam(file: Path = SHIPPED / "actuated-beam" / "beam.layup-1.vtkhdf") -> Problem:
    """Lay-up 1 of the actuated beam, half a turn of its crank."""
    return from_case(
        Path("cases/actuated-beam/case.toml"),
        "layup-1",
        {"beam": file},
        "tip_z",
        1.0,
        title="actuated beam, lay-up 1, 16 elements, 7 modes, 1 s",
    )


def chain(n: int, t_end: float = 1.0, file: Path = EIGHT / "hand.vtkhdf") -> Problem:
    """Chain of n flexible links, released at rest from the horizontal; probe at its end.

    Every link is the hand of the double pendulum without its mass.
    """
    package = read_package(file)
    link = flexible_body("link", package)
    root, tip = interface(package, "root"), interface(package, "tip")
    length = float(tip.position_B[0])
    hinge = frame_from_axis(np.array([0.0, 0.0, 1.0]))
    markers, joints = [MarkerTable(GROUND, np.zeros(3), hinge)], []
    for i in range(n):
        for end in (root, tip):
            markers.append(MarkerTable(i, end.position_B, hinge, end.phi_B, end.psi_B))
        # marker 0 is the ground's; 2 i is the tip of the link before
        joints.append(JointTable(f"hinge {i + 1}", "revolute", 2 * i, 2 * i + 1))
    model = assemble_model([link] * n, markers, joints, gravity_G=GRAVITY)
    y0 = np.zeros(model.n_pos + model.n_vel + 1)
    y0[model.pos_start] = length * np.arange(n)
    y0[model.pos_start + 3] = 1.0
    title = f"chain of {n} links, {package.n_mode} modes each, {t_end:g} s"
    return Problem(f"chain-{n}", title, model, y0, 2 * n, t_end, 0.01)
