"""A beam of a table of stations: curved, twisted, tapered, with couplings of all kinds."""

from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.optimize
from samples.beam_samples import coupled_stiffness

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.inputs.case.bodies.beams import line_of
from plymotion.solver.inputs.case.tables.beam_keys import (
    COLUMNS,
    PLACES,
    TRAPEZE,
    TWIST,
    UPPER,
    BeamBody,
    Spline,
)
from plymotion.solver.math.rotations import skew

STEPS = 600

AT = np.array([0.0, 0.15, 0.4, 0.7, 1.0])
STIFFNESS = coupled_stiffness(np.diag([4e3, 1e3, 1.2e3, 20.0, 30.0, 25.0]))
MASS = SectionMass(1.0, np.array([0.0, 0.02, -0.01]), np.diag([0.03, 0.018, 0.012])).matrix()
SHARE = 1.0 - 0.7 * AT  # of K and M at the root
POINTS = np.column_stack([1.5 * AT, 0.1 * AT**2, -0.2 * AT**2])
ANGLES = -40.0 * (1.0 - AT)  # [deg]


def columns() -> dict[str, list[float]]:
    found = dict(zip(PLACES, POINTS.T.tolist(), strict=True))
    found[TWIST] = ANGLES.tolist()
    for letter, matrix in (("K", STIFFNESS), ("M", MASS)):
        for i, j in UPPER:
            found[f"{letter}{i + 1}{j + 1}"] = (SHARE * matrix[i, j]).tolist()
    return {name: found[name] for name in COLUMNS} | {a: [0.01] * len(AT) for a in TRAPEZE}


def write_table(file: Path, table: dict[str, list[float]] | None = None) -> Path:
    found = table or columns()
    rows = zip(*found.values(), strict=True)
    lines = ["# a remark", ",".join(found), *(",".join(map(repr, row)) for row in rows)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def rod_frequencies(body: BeamBody, near: np.ndarray) -> tuple[np.ndarray, float]:
    """Clamped-free frequencies of a beam of a table next to `near` [rad/s], and its mass [kg].

    No elements: the linear equations of the rod, u' = gamma + f x t, f' = kappa, F' = -w2 p,
    M' = -w2 l - t x F in body axes, are integrated along the spline. The determinant of the free
    end vanishes at a frequency.
    """
    points = np.array(body.line.points)
    spline, line = Spline(points), line_of(body)
    at = np.array([station.at for station in body.stations])
    s = (np.arange(STEPS) + 0.5) / STEPS
    t = spline.tangent(s)
    x2 = line.x2(s)
    R = np.stack([t, x2, np.cross(t, x2)], axis=2)
    tables = [np.array([getattr(x, key) for x in body.stations]) for key in ("stiffness", "mass")]
    K, M = (
        np.array([[np.interp(s, at, A[:, i, j]) for j in range(6)] for i in range(6)])
        for A in tables
    )
    h = spline.length / STEPS
    T = np.zeros((STEPS, 6, 6))
    T[:, :3, :3] = T[:, 3:, 3:] = R
    S_B = T @ np.linalg.inv(np.moveaxis(K, 2, 0)) @ T.swapaxes(1, 2)
    M_B = T @ np.moveaxis(M, 2, 0) @ T.swapaxes(1, 2)
    size = np.sqrt(np.diag(K[..., 0]))
    scale = np.concatenate([np.ones(6), size])  # unknowns of even size
    across = np.array([skew(e) for e in t])

    def determinant(w: float) -> float:
        state = np.eye(12)[:, 6:]
        for k in range(STEPS):
            A = np.zeros((12, 12))
            A[:3, 3:6], A[9:, 6:9] = -across[k], -across[k]
            A[:6, 6:], A[6:, :6] = S_B[k], -(w**2) * M_B[k]
            state = scipy.linalg.expm(h * A * scale[None] / scale[:, None]) @ state
        return float(np.linalg.det(state[6:]))

    roots = [scipy.optimize.brentq(determinant, 0.97 * w, 1.03 * w, rtol=1e-9) for w in near]
    return np.array(roots), h * float(M[0, 0].sum())
