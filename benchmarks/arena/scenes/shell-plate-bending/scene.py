"""Navier's solution of cross-ply plates, first-order theory, SS-1 edges, one half wave each way.

u = U cos sin, v = V sin cos, w = W sin sin, rotations X cos sin and Y sin cos; shear factor 5/6.
"""

import tomllib
from pathlib import Path

import numpy as np
from scipy.linalg import eigh

ROOT = Path(__file__).resolve().parents[4]
FILES = {
    "scene_shell_plate_bending": ROOT / "cases/shells/plate-laminated.toml",
    "scene_shell_plate_frequencies": ROOT / "cases/shells/plate-frequencies.toml",
    "scene_shell_plate_buckling": Path(__file__).parents[1] / "shell-plate-buckling/panel.toml",
}


def truth(_: object) -> list[float]:
    """Deflection in the centre [m], first frequency [Hz] or load factor of N11."""
    table = tomllib.loads(FILES[__name__].read_text())
    (laminate,), (m,) = table["laminates"].values(), table["materials"].values()
    size, t = table["mesh"]["parameters"], laminate["ply_thickness"]
    plies = laminate["angles_deg"] + laminate["angles_deg"][::-1] * laminate.get("symmetric", False)
    h = t * len(plies)
    free = m["E1"] / (m["E1"] - m["nu12"] ** 2 * m["E2"])
    A, B, D, S = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((2, 2))
    for k, angle in enumerate(plies):
        E, G = [m["E1"], m["E2"]], [m["G13"], m["G23"]]
        if angle == 90:
            E, G = E[::-1], G[::-1]
        Q = np.diag([free * E[0], free * E[1], m["G12"]])
        Q[0, 1] = Q[1, 0] = free * m["nu12"] * m["E2"]
        low, high = -h / 2 + k * t, -h / 2 + (k + 1) * t
        A, B = A + Q * t, B + Q * (high**2 - low**2) / 2
        D, S = D + Q * (high**3 - low**3) / 3, S + 5 / 6 * np.diag(G) * t
    a, b = np.pi / size["length"], np.pi / size["width"]
    e = np.array([[-a, 0, 0, 0, 0], [0, -b, 0, 0, 0], [b, a, 0, 0, 0]])
    k = np.roll(e, 3, axis=1)
    g = np.array([[0, 0, a, 1, 0], [0, 0, b, 0, 1]])
    K = e.T @ A @ e + e.T @ B @ k + k.T @ B @ e + k.T @ D @ k + g.T @ S @ g
    if "frequencies" in table:
        M = m["rho"] * np.diag([h, h, h, h**3 / 12, h**3 / 12])
        return [float(np.sqrt(eigh(K, M, eigvals_only=True)[0]) / (2 * np.pi))]
    flexible = np.linalg.inv(K)[2, 2]  # of the load on w
    return [flexible if "buckling" not in table else 1.0 / (flexible * 1e3 * a * a)]
