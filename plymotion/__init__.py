"""Flexible multibody dynamics with laminated composite members.

Two halves meet in one file: `plymotion.preprocess` (FEniCSx) writes a modal
package per body, `plymotion.solver` (NumPy) reads packages and integrates the
mechanism. docs/adr/0001 says where both lie.

    import plymotion as pm

    result = pm.run("case.toml", "base")
    result.signals["tip_z"].plot()

docs/python.md explains the names below. Each is imported when it is asked for.
"""

import os as _os
import sys as _sys
from importlib import import_module as _import_module
from importlib.machinery import PathFinder as _PathFinder

__version__ = "0.1.0"

# Module of this folder -> public names; __init__.pyi tells their types.
_NAMES = {
    "api.bodies": (
        *("Package", "Shell", "Solid", "export", "import_body", "info", "shell", "solid"),
        "validate",
    ),
    "api.blade": ("Blade", "blade"),
    "api.case": ("Case", "load"),
    "api.component": ("openmdao_component",),
    "api.modes": ("Campbell", "Modes", "campbell", "modes"),
    "api.optimising": ("Optimum", "optimise"),
    "api.planning": ("Plan", "plan"),
    "api.result": ("Result", "run"),
    "api.section": ("Section", "section"),
    "api.sensitivities": ("Sensitivities", "sensitivities"),
    "api.signal": ("Signal", "norm"),
    "api.simulation": ("Simulation", "simulate"),
    "api.sweeping": ("Sweep", "sweep"),
    "solver.errors": ("InputError", "PackageError"),
}
_PUBLIC = {name: module for module, names in _NAMES.items() for name in names}
__all__ = sorted([*_PUBLIC, "__version__"])


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(_import_module(f"{__name__}.{_PUBLIC[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__


class _Halves:
    """Find the halves beside this folder, as in a checkout, and nothing else that lies there."""

    folders = (_os.path.dirname(_os.path.dirname(_os.path.realpath(__file__))),)
    names = (f"{__name__}.solver", f"{__name__}.preprocess")

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return _PathFinder.find_spec(name, cls.folders) if name in cls.names else None


if not _os.path.isdir(_os.path.join(__path__[0], "solver")):  # inside in an installed package
    _sys.meta_path.append(_Halves)
