"""The obstacle course of shells and the beams of MacNeal and Harder, of isotropic shells."""

from typing import Any

from samples.shell_model import Model, Problem, isotropic


def shell(script: str, mesh: dict[str, Any], E: float, nu: float, h: float) -> Model:
    """One isotropic region."""
    stack, materials = isotropic(E, nu, h)
    return Model(script, mesh, materials, {"wall": stack}, {"all": "wall"}, {})


def scordelis(n: Any) -> Problem:
    model = shell("cylinder", {"n_length": n, "n_around": n}, 4.32e8, 0.0, 0.25)
    model.supports = {
        "middle": {"at": "near", "fixed": "symmetry-x"},
        "diaphragm": {"at": "far", "fixed": ["uy", "uz"]},
        "crown": {"at": "first", "fixed": "symmetry-y"},
    }
    model.loads = {"weight": {"all": {"force_per_area": [0.0, 0.0, -90.0]}}}
    return model, lambda solved: -solved.probe("near-second", "uz")


def pinched_cylinder(n: Any) -> Problem:
    mesh = {"radius": 300.0, "length": 300.0, "second_deg": 90.0, "n_length": n, "n_around": n}
    model = shell("cylinder", mesh, 3e6, 0.3, 3.0)
    model.supports = {
        "middle": {"at": "near", "fixed": "symmetry-x"},
        "diaphragm": {"at": "far", "fixed": ["uy", "uz"]},
        "top": {"at": "first", "fixed": "symmetry-y"},
        "side": {"at": "second", "fixed": "symmetry-z"},
    }
    model.loads = {"pinch": {"F": {"at": "near-first", "force": [0.0, 0.0, -0.25]}}}
    return model, lambda solved: -solved.probe("near-first", "uz")


def hemisphere(n: Any) -> Problem:
    model = shell("hemisphere", {"n_around": n, "n_up": n}, 6.825e7, 0.3, 0.04)
    model.supports = {
        "side-x": {"at": "side-x", "fixed": "symmetry-y"},
        "side-y": {"at": "side-y", "fixed": "symmetry-x"},
        "height": {"at": "at-x", "fixed": ["uz"]},
    }
    model.loads = {
        "pull": {
            "x": {"at": "at-x", "force": [1.0, 0.0, 0.0]},
            "y": {"at": "at-y", "force": [0.0, -1.0, 0.0]},
        }
    }
    return model, lambda solved: solved.probe("at-x", "ux")


def straight_beam(n: Any, direction: str) -> Problem:
    mesh = {"length": 6.0, "width": 0.2, "n_length": n[0], "n_width": n[1]}
    model = shell("plate", mesh, 1e7, 0.3, 0.1)
    row = {"ext": 0, "in": 1, "out": 2}[direction]
    return _tip_loaded(model, "left", "right", row)


def curved_beam(n: Any) -> Problem:
    model = shell("curved-beam", {"n_length": n[0], "n_width": n[1]}, 1e7, 0.25, 0.1)
    return _tip_loaded(model, "root", "tip", 0)


def twisted_beam(n: Any, direction: str) -> Problem:
    model = shell("twisted-beam", {"n_length": n[0], "n_width": n[1]}, 29e6, 0.22, 0.32)
    return _tip_loaded(model, "root", "tip", {"y": 1, "z": 2}[direction])


def _tip_loaded(model: Model, root: str, tip: str, row: int) -> Problem:
    force = [0.0, 0.0, 0.0]
    force[row] = 1.0
    model.supports = {"root": {"at": root, "fixed": "all"}}
    model.loads = {"F": {"tip": {"at": tip, "force": force}}}
    return model, lambda solved: solved.probe(tip, ("ux", "uy", "uz")[row])
