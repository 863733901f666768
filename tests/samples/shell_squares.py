"""Square plates in z = 0 as shell problems: closed forms, series and NAFEMS."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from samples.shell_model import Model, Problem, isotropic, laminate

Array = NDArray[np.float64]
FIVE_SIXTHS = "5/6"


EDGES_X, EDGES_Y = ("left", "right"), ("bottom", "top")
# fixed on the edges x = const and on the edges y = const
HARD = (["ux", "uy", "uz", "rx", "rz"], ["ux", "uy", "uz", "ry", "rz"])
SS1 = (["uy", "uz", "rx"], ["ux", "uz", "ry"])
SS2 = (["ux", "uz", "rx"], ["uy", "uz", "ry"])


def square(n: Any, side: float, stack: dict[str, Any], materials: Any, edges: Any) -> Model:
    """A square plate; `edges` holds what is fixed on x = const and on y = const."""
    nx, ny = (n, n) if isinstance(n, int) else n
    supports = {
        name: {"at": name, "fixed": fixed}
        for names, fixed in zip((EDGES_X, EDGES_Y), edges, strict=True)
        for name in names
        if fixed
    }
    mesh = {"length": side, "width": side, "n_length": nx, "n_width": ny}
    return Model("plate", mesh, materials, {"wall": stack}, {"all": "wall"}, supports)


def centre(solved: Any) -> float:
    """Displacement w of the centre."""
    return float(solved.probe("centre", "uz"))


def mindlin(n: Any, slenderness: str) -> Problem:
    h, E, nu = 1.0 / float(slenderness), 1.0, 0.3
    stack, materials = isotropic(E, nu, h)
    model = square(n, 1.0, stack, materials, HARD)
    model.loads = {"q": {"all": {"force_per_area": [0.0, 0.0, 1.0]}}}
    stiffness = E * h**3 / (12.0 * (1.0 - nu**2))
    return model, lambda solved: 100.0 * stiffness * centre(solved)


def clamped(n: Any) -> Problem:
    h, E, nu = 1e-3, 1.0, 0.3
    stack, materials = isotropic(E, nu, h)
    model = square(n, 1.0, stack, materials, ("all", "all"))
    model.loads = {"q": {"all": {"force_per_area": [0.0, 0.0, 1.0]}}}
    stiffness = E * h**3 / (12.0 * (1.0 - nu**2))
    return model, lambda solved: 100.0 * stiffness * centre(solved)


def lamina(E1: float, G12: float, G23: float) -> dict[str, Any]:
    """Moduli over E2; density 1."""
    moduli = {"E1": E1, "E2": 1.0, "E3": 1.0, "G12": G12, "G13": G12, "G23": G23}
    return {"kind": "orthotropic", **moduli, "nu12": 0.25, "nu13": 0.25, "nu23": 0.25, "rho": 1.0}


def angles(word: str) -> list[float]:
    """Plies of a name such as 0_90_90_0 or 45_m45."""
    return [float(part.replace("m", "-")) for part in word.split("_")]


def cross_ply(n: Any, load: str, word: str, ratio: str) -> Problem:
    h = 1.0 / float(ratio)
    stack = laminate("ply", angles(word), h, FIVE_SIXTHS)
    model = square(n, 1.0, stack, {"ply": lamina(25.0, 0.5, 0.2)}, SS1)
    model.loads = {"q": {"all": area_load(load)}}
    return model, lambda solved: 100.0 * h**3 * centre(solved)


def area_load(kind: str) -> dict[str, Any]:
    """Load 1 per area, or sin sin."""
    load: dict[str, Any] = {"force_per_area": [0.0, 0.0, 1.0]}
    return {**load, "sine": [1.0, 1.0, 0.0]} if kind == "sin" else load


def angle_ply(n: Any, ratio: str) -> Problem:
    h = 1.0 / float(ratio)
    stack = laminate("ply", [45.0, -45.0], h, FIVE_SIXTHS)
    model = square(n, 1.0, stack, {"ply": lamina(40.0, 0.6, 0.5)}, SS2)
    model.loads = {"q": {"all": area_load("sin")}}
    return model, lambda solved: 100.0 * h**3 * centre(solved)


def bending_frequency(solved: Any) -> float:
    """Circular frequency of the mode that is most like sin sin in w: in-plane ones are left out."""
    x, y = solved.points_G[:, 0], solved.points_G[:, 1]
    like = np.sin(np.pi * x) * np.sin(np.pi * y)
    w = solved.shapes[:, 2]
    row = int(np.argmax(np.abs(like @ w) / np.linalg.norm(solved.shapes[:, :3], axis=(0, 1))))
    return float(2.0 * np.pi * solved.frequencies[row])


def vibrating(n: Any, ratio: float, plies: list[float], E1: float, edges: Any) -> Problem:
    h = 1.0 / ratio
    stack = laminate("ply", plies, h, FIVE_SIXTHS)
    model = square(n, 1.0, stack, {"ply": lamina(E1, 0.6, 0.5)}, edges)
    model.frequencies = {"count": 4}
    return model, lambda solved: bending_frequency(solved) / h


def khdeir(n: Any, count: str, angle: str) -> Problem:
    plies = [float(angle), -float(angle)] * (int(count) // 2)
    return vibrating(n, 10.0, plies, 40.0, SS2)


def cross_ply_by_modulus(n: Any, E1: str) -> Problem:
    return vibrating(n, 5.0, [0.0, 90.0, 90.0, 0.0], float(E1), SS1)


def cross_ply_by_thickness(n: Any, word: str, ratio: str) -> Problem:
    return vibrating(n, float(ratio), angles(word), 40.0, SS1)


def in_plane(n: Any, edges: Any = SS1) -> Problem:
    """Vibration of a square in its plane, supported as SS-1: shear waves, 1, 1, sqrt(2) exactly."""
    stack, materials = isotropic(1.0, 0.3, 1e-2)  # thin: drilling inertia does not matter
    model = square(n, 1.0, stack, materials, edges)
    model.supports["bending"] = {"at": "plate", "fixed": ["uz", "rx", "ry"]}
    model.frequencies = {"count": 3}
    return model, lambda solved: 2.0 * solved.frequencies[:3] / np.sqrt(1.0 / 2.6)


def lardeur(n: Any) -> Problem:
    plies = [(0.0, 0.025), (90.0, 0.05), (0.0, 0.025)]
    stack = {
        "plies": [{"material": "ply", "angle_deg": a, "thickness": t} for a, t in plies],
        "shear_correction": "energy-1d",
    }
    model = square(n, 1.0, stack, {"ply": lamina(25.0, 0.5, 0.2)}, SS1)
    model.loads = {"q": {"all": {"force_per_area": [0.0, 0.0, 0.01], "sine": [1.0, 1.0, 0.0]}}}
    return model, centre


def strip(n: Any) -> Problem:
    """Half of the strip, from mid-span (left) to the support (right); the overhang is idle."""
    thickness = 1e-4 * np.array([1.0, 1.0, 1.0, 4.0, 1.0, 1.0, 1.0])
    plies = zip([0.0, 90.0] * 3 + [0.0], thickness, strict=True)
    ply = {"E1": 1e11, "E2": 5e9, "E3": 5e9, "G12": 3e9, "G13": 2e9, "G23": 2e9}
    ply |= {"nu12": 0.4, "nu13": 0.4, "nu23": 0.3, "rho": 1.0}
    stack = {
        "plies": [{"material": "ply", "angle_deg": a, "thickness": float(t)} for a, t in plies],
        "shear_correction": FIVE_SIXTHS,
    }
    model = square(n, 0.0, stack, {"ply": {"kind": "orthotropic", **ply}}, ([], []))
    model.mesh |= {"length": 0.015, "width": 0.010}
    model.supports = {
        "mid-span": {"at": "left", "fixed": "symmetry-x"},
        "roller": {"at": "right", "fixed": ["uz"]},
        "corner": {"at": "corner-00", "fixed": ["uy"]},
    }
    model.loads = {"F": {"line": {"at": "left", "force_per_length": [0.0, 0.0, -5000.0]}}}

    def read(solved: Any) -> Array:
        w = 1e3 * solved.probe("left", "uz")
        near = solved.cells_between(0.0, 0.5e-3)
        middle = solved.points_G[solved.cells[near]].mean(axis=1)[:, 0]
        # a cell holds the mean of a moment that falls linearly to zero at the support
        below = solved.ply_stress(near)[:, 0, 0, 0] / (1.0 - middle / 0.015)
        # between the outer ply and the next one, where the shear force is even
        shear = solved.ply_stress(solved.cells_between(0.004, 0.010))[:, 0, 2, 4]
        return np.array([w, 1e-6 * below.mean(), -1e-6 * shear.mean()])

    return model, read


NAFEMS = (200e9, 0.3, 8000.0)


def free_plate(n: Any) -> Problem:
    stack, materials = isotropic(NAFEMS[0], NAFEMS[1], 0.05, NAFEMS[2])
    model = square(n, 10.0, stack, materials, ([], []))
    model.frequencies = {"count": 6, "free": True}
    return model, lambda solved: solved.elastic[:6]


def cantilever_square(n: Any) -> Problem:
    stack, materials = isotropic(NAFEMS[0], NAFEMS[1], 0.05, NAFEMS[2])
    model = square(n, 10.0, stack, materials, ([], []))
    model.supports = {"root": {"at": "left", "fixed": "all"}}
    model.frequencies = {"count": 6}
    return model, lambda solved: solved.frequencies[:6]


def thick_plate(n: Any) -> Problem:
    stack, materials = isotropic(NAFEMS[0], NAFEMS[1], 1.0, NAFEMS[2])
    model = square(n, 10.0, stack, materials, HARD)
    model.supports["in-plane"] = {"at": "plate", "fixed": ["ux", "uy", "rz"]}
    model.frequencies = {"count": 4}
    return model, lambda solved: solved.frequencies[:4]


def _barton(problem: Problem, count: int) -> Problem:
    model, read = problem
    E, nu, rho = NAFEMS
    unit = np.sqrt(E * 0.05**2 / (12.0 * rho * (1.0 - nu**2))) / (2.0 * np.pi * 100.0)
    return model, lambda solved: read(solved)[:count] / unit


def barton_cantilever(n: Any) -> Problem:
    return _barton(cantilever_square(n), 6)


def barton_free(n: Any) -> Problem:
    return _barton(free_plate(n), 5)
