"""The benchmarks' mechanisms in Exudyn (exudyn_plane.py), from the same modal packages.

Bodies have the package's modes, masses and stiffness; point masses on interfaces are added to the
body's own sums, which saves Exudyn their coordinates.
"""

from itertools import pairwise

import numpy as np
from exudyn_plane import FULL, MODIFIED, Plane, Reduced, exudyn
from exudyn_plane import double_pendulum as assembled
from solver_problems import EIGHT, GRAVITY, interface, node

from plymotion.solver.math.arrays import Array
from plymotion.solver.math.rotations import skew
from plymotion.solver.package import ModalPackage, read_package

__all__ = ["FULL", "MODIFIED", "chain", "double_pendulum", "exudyn", "links", "reduced"]


def reduced(package: ModalPackage, masses: dict[str, float] | None = None) -> Reduced:
    """Arrays of a package with point masses (interface -> kg) added to its sums."""
    i, m = package.invariants, package.n_mode
    mass, S0, T00, S, T01, T11 = i.mass, i.S0_B, i.T00_B, i.S_B, i.T01_B, i.T11_B
    M_qq, weights = package.mass, package.node_mass.copy()
    for name, kg in (masses or {}).items():
        at = interface(package, name)
        x, phi = at.position_B, at.phi_B
        mass, S0, T00 = mass + kg, S0 + kg * x, T00 + kg * np.outer(x, x)
        S, M_qq = S + kg * phi, M_qq + kg * phi.T @ phi
        T01 = T01 + kg * np.einsum("a,bi->abi", x, phi)
        T11 = T11 + kg * np.einsum("ai,bj->abij", phi, phi)
        weights[node(package, name)] += kg
    eye, eps = np.eye(3), _permutations()
    return Reduced(
        mass=mass,
        inertia=np.trace(T00) * eye - T00 + i.J0_B,
        centre=S0 / mass,
        nodes=package.nodes_B,
        basis=package.shapes_B[:, :, :3].reshape(m, -1).T.copy(),
        M_qq=M_qq,
        K_qq=package.stiffness,
        mPhitTPsi=S,
        mPhitTPsiTilde=np.hstack([skew(S[:, k].copy()) for k in range(m)]),
        mXRefTildePsi=-(np.einsum("abc,abi->ci", eps, T01) + i.J_psi_B),
        mPsiTildePsi=-np.einsum("abc,abij->icj", eps, T11).reshape(3 * m, m),
        mXRefTildePsiTilde=np.hstack(
            [np.trace(T01[..., k]) * eye - T01[..., k].T for k in range(m)]
        ),
        mPsiTildePsiTilde=np.block(
            [
                [np.trace(T11[..., k, j]) * eye - T11[..., k, j].T for j in range(m)]
                for k in range(m)
            ]
        ),
        weights=weights / weights.sum(),
        tip=node(package, package.interfaces[-1].name),
    )


def links() -> tuple[Reduced, Reduced]:
    """Arm with M1 and hand with M2 of the double pendulum."""
    arm, hand = (read_package(EIGHT / f"{body}.vtkhdf") for body in ("arm", "hand"))
    return reduced(arm, {"tip": 1.0}), reduced(hand, {"tip": 3.0})


def double_pendulum(
    steps: int, newton: str, *, gravity: str = "nodes", g: float = -GRAVITY[1], t_end: float = 1.0
) -> tuple[Array, float]:
    """Tip (k, 3) of the double pendulum every 0.01 s, and the processor time [s]."""
    plane, sensor = assembled(*links(), gravity, g)
    cpu = plane.solve(t_end, steps, newton)
    return plane.path(sensor), cpu


def chain(n: int, steps: int, h: float, newton: str) -> tuple[Array, float]:
    """Chain of n links: path of its end and the processor time [s], sparse solver if it is long."""
    package = read_package(EIGHT / "hand.vtkhdf")
    link = reduced(package)
    length = float(interface(package, "tip").position_B[0])
    plane = Plane()
    bodies = [plane.body(link, (i * length, 0.0)) for i in range(n)]
    plane.hinge(plane.ground, bodies[0][0])
    for (_, before), (frame, _) in pairwise(bodies):
        plane.hinge(plane.at_node(before, link.tip), frame)
    sensor = plane.sensor(bodies[-1][1], link.tip)
    cpu = plane.solve(steps * h, steps, newton, sparse=n > 4)
    return plane.path(sensor), cpu


def _permutations() -> Array:
    eps = np.zeros((3, 3, 3))
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        eps[a, b, c], eps[b, a, c] = 1.0, -1.0
    return eps
