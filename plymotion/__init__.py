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

# Public name -> module of this folder; __init__.pyi tells their types.
_PUBLIC = {
    "Campbell": "api.modes",
    "Blade": "api.blade",
    "Case": "api.case",
    "InputError": "solver.errors",
    "Modes": "api.modes",
    "Optimum": "api.optimising",
    "Package": "api.bodies",
    "PackageError": "solver.errors",
    "Result": "api.result",
    "Section": "api.section",
    "Sensitivities": "api.sensitivities",
    "Shell": "api.bodies",
    "Signal": "api.signal",
    "Simulation": "api.simulation",
    "Solid": "api.bodies",
    "Sweep": "api.sweeping",
    "Plan": "api.planning",
    "campbell": "api.modes",
    "export": "api.bodies",
    "import_body": "api.bodies",
    "info": "api.bodies",
    "blade": "api.blade",
    "load": "api.case",
    "modes": "api.modes",
    "norm": "api.signal",
    "openmdao_component": "api.component",
    "optimise": "api.optimising",
    "plan": "api.planning",
    "run": "api.result",
    "section": "api.section",
    "sensitivities": "api.sensitivities",
    "shell": "api.bodies",
    "simulate": "api.simulation",
    "solid": "api.bodies",
    "sweep": "api.sweeping",
    "validate": "api.bodies",
}
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
