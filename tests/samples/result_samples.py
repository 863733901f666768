"""A swinging rod for tests of results and report: the exact pendulum, sampled.

A rigid rod of length L and mass M hangs from a hinge and starts at rest at an
angle; theta'' = -(3 g / 2 L) sin(theta) is integrated by SciPy to 1e-11. A
second body, a rigid block without cells, rides on the tip.
"""

import dataclasses

import numpy as np
from scipy.integrate import solve_ivp

from plymotion.solver.results import BodyGeometry, RunResult, Signal
from plymotion.solver.results.run_result import BodyView, Link, Side
from plymotion.solver.results.surfaces import all_positions, rigid_surface

GRAVITY = 9.81


def swinging_rod(
    run: str = "rod",
    length: float = 0.8,
    mass: float = 1.2,
    t_end: float = 2.0,
    k: int = 501,
    start_deg: float = 60.0,
) -> RunResult:
    """Compute the swing of a rod; the signals are the tip's position and the angle."""
    t = np.linspace(0.0, t_end, k)
    factor = 1.5 * GRAVITY / length
    solution = solve_ivp(
        lambda _, y: [y[1], -factor * np.sin(y[0])],
        (0.0, t_end),
        [np.radians(start_deg), 0.0],
        t_eval=t,
        rtol=1e-11,
        atol=1e-12,
        method="DOP853",
    )
    angle, rate = solution.y
    direction = np.column_stack([np.sin(angle), -np.cos(angle), np.zeros(k)])
    n = 9
    x = np.linspace(0.0, length, n)
    rod = direction[:, None, :] * x[None, :, None]
    tip = length * direction
    zero = np.zeros(k)
    nodes = np.column_stack([x, np.zeros(n), np.zeros(n)])
    edges = np.column_stack([np.arange(n - 1), np.arange(1, n)]).ravel()
    none = np.zeros(0, dtype=np.int64)
    return RunResult(
        case="swing",
        run=run,
        t=t,
        signals=(
            Signal("tip_x", "m", "tip, horizontal", tip[:, 0]),
            Signal("tip_y", "m", "tip, vertical", tip[:, 1]),
            Signal("angle", "rad", "angle from the vertical", angle),
        ),
        q=np.column_stack([zero, zero, zero, np.cos(angle / 2), zero, zero, np.sin(angle / 2)]),
        v=np.column_stack([zero, zero, zero, zero, zero, rate]),
        multipliers=np.column_stack([zero, mass * GRAVITY + zero]),
        energies={
            "kinetic": mass * length**2 * rate**2 / 6,
            "strain": zero,
            "potential": -mass * GRAVITY * length / 2 * np.cos(angle),
            "drive_work": zero,
        },
        bodies=(
            BodyGeometry("rod", nodes, edges, np.arange(0, 2 * n, 2), np.full(n - 1, 3)),
            BodyGeometry("block", np.zeros((1, 3)), none, np.zeros(1, dtype=np.int64), none),
        ),
        node_positions_G=np.concatenate([rod, tip[:, None, :]], axis=1),
        violations={"position": np.abs(np.linalg.norm(tip, axis=1) - length)},
    )


def crowd(count: int, k: int = 5) -> RunResult:
    """Free rigid bodies in a row, a joint and a signal for each; sizes differ."""
    t = np.linspace(0.0, 1.0, k)
    q = np.zeros((k, 7 * count))
    q[:, 0::7] = np.arange(count) + t[:, None]
    q[:, 3::7] = 1.0
    bodies, links, signals = [], [], []
    none = np.zeros(0, dtype=np.int64)
    for i in range(count):
        nodes = np.zeros((1 + i % 3, 3))
        nodes[1:, 0] = 0.5
        view = BodyView(
            first_position=7 * i,
            shapes_B=np.zeros((0, len(nodes), 6)),
            stiffness=np.zeros((0, 0)),
            frequencies=np.zeros(0),
            labels=(),
            mass=1.0 + i,
            centre_B=np.zeros(3),
            draw=lambda nodes=nodes: rigid_surface(
                nodes, np.zeros(3), np.ones(3), np.eye(3), 0.1, 1.0
            ),
        )
        name = f"Körper-{i}"
        bodies.append(BodyGeometry(name, nodes, none, np.zeros(1, dtype=np.int64), none, view))
        side = Side(i, np.full(3, float(i)), np.eye(3), np.zeros((3, 0)), np.zeros((3, 0)))
        links.append(Link(f"j{i}", "spherical", (side, side), ("about x",)))
        signals.append(Signal(f"s{i}", "m", f"number {i}", np.sin(i + t)))
    zero = np.zeros(k)
    moved = [
        (7 * i, body.nodes_B, np.zeros((0, len(body.nodes_B), 3))) for i, body in enumerate(bodies)
    ]
    return dataclasses.replace(
        swinging_rod(k=k),
        t=t,
        q=q,
        v=np.zeros((k, 6 * count)),
        multipliers=np.zeros((k, 3)),
        energies=dict.fromkeys(("kinetic", "strain", "potential", "drive_work"), zero),
        violations={},
        bodies=tuple(bodies),
        links=tuple(links),
        signals=tuple(signals),
        node_positions_G=all_positions(q, moved),
        provenance={"command": "x" * 100_000},  # longer than an attribute of HDF5
    )
