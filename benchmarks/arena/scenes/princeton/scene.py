"""Cantilevers under a dead force F at the tip, large rotations: Princeton's beam, the 45 deg bend.

Truth: Reissner's and Simo's beam, r' = R (e1 + gamma), R' = R skew(k0 + kappa), m' = -r' x F with
gamma and kappa from the 6x6 stiffness. The three moments at the root are found by shooting.
"""

import numpy as np
from samples.segment_samples import cantilever
from scipy.integrate import solve_ivp
from scipy.optimize import root

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.math.rotations import skew

BENT = __name__ == "scene_bend_45"
if BENT:  # Bathe and Bolourchi: radius 100, section 1 x 1, E = 1e7, nu = 0
    E, LENGTH, FORCE = 1e7, 25.0 * np.pi, np.array([0.0, 0.0, 600.0])
    K = np.diag([E, 5 / 12 * E, 5 / 12 * E, E / 12, E / 12, E / 12])
    M = SectionMass(1.0, np.zeros(3), np.diag([1 / 6, 1 / 12, 1 / 12])).matrix()
    CURVED, BODY = np.array([0.0, 0.0, 0.01]), {"line": {"arc_deg": 45.0}}
else:  # Dowell and Traybar: 45 deg, 13.345 N; data of tests/reference/dynamics/large_rotations.toml
    E, LENGTH, H, W = 71.7e9, 0.508, 12.3777e-3, 3.2024e-3
    G, I2, I3 = E / 2.62, H * W**3 / 12, W * H**3 / 12
    FORCE = 13.345 * np.array([0.0, -1.0, 1.0]) / np.sqrt(2.0)
    K = np.diag([E * H * W, G * H * W, G * H * W, 0.198 * G * (I2 + I3), E * I2, E * I3])
    M = SectionMass(2700 * H * W, np.zeros(3), 2700 * np.diag([I2 + I3, I2, I3])).matrix()
    CURVED, BODY = np.zeros(3), {}
matrices = (K, M)
beam = {"K": K, "length": LENGTH, "curvature": CURVED, "force": FORCE, "static": True}


def table(segments: int) -> dict:
    """The case, with the load from the start."""
    found = cantilever(segments, LENGTH, body=BODY)
    size = float(np.linalg.norm(FORCE))
    load = {"kind": "force", "at": "beam.tip", "direction": (FORCE / size).tolist()}
    found["forces"] = {"load": load | {"law": {"constant": size}}}
    found["solver"] |= {"t_end": 0.01, "output_step": 0.01, "start": "equilibrium"}
    found["signals"] = {
        axis: {"kind": "position", "at": "beam.tip", "component": axis} for axis in "xyz"
    }
    return found


def truth(times: np.ndarray) -> np.ndarray:
    """Position (1, 3) of the tip [m]."""

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        R, m = y[3:12].reshape(3, 3), y[12:]
        strain = np.linalg.solve(K, np.concatenate([R.T @ FORCE, R.T @ m]))
        slope = R @ (np.eye(3)[0] + strain[:3])
        turn = R @ skew(CURVED + strain[3:])
        return np.concatenate([slope, turn.ravel(), -np.cross(slope, FORCE)])

    def end(moment: np.ndarray) -> np.ndarray:
        y = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])
        return solve_ivp(rates, (0.0, LENGTH), y, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]

    reach = np.array([LENGTH, 0.0, 0.0])
    if BENT:
        reach = 100.0 * np.array([np.sin(np.pi / 4), 1.0 - np.cos(np.pi / 4), 0.0])
    scale = LENGTH * np.linalg.norm(FORCE)
    found = root(lambda m: end(m * scale)[12:] / scale, np.cross(0.7 * reach, FORCE) / scale)
    found = root(lambda m: end(m * scale)[12:] / scale, found.x, tol=1e-13)
    return end(found.x * scale)[None, :3]
