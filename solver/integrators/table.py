"""The integrators of this folder and of generic/ by name, and how to make one without a case."""

from abc import ABCMeta
from collections.abc import Iterable
from inspect import isabstract
from pathlib import Path
from typing import Any

from ..dynamics.elements.constraints.treatment import IMPLICIT, TREATMENTS, Treatment
from ..errors import InputError, did_you_mean
from ..math.arrays import Array
from ..math.catalogue import by_name, catalogue
from . import __name__ as _package
from . import __path__ as _path
from .generic.base import Derivative, Integrator

FIRST_ARGUMENTS = ("derivative", "model")
NO_INTEGRATORS = ("table", "choice", "generic", "compiled", "force_variation", "expression_breaks")


def classes_of(package: str, path: Iterable[str]) -> list[type[Integrator]]:
    """Return the classes of a package that a case can name.

    Raises
    ------
    ValueError : a class that does not keep the contract (contract.py)
    """
    classes = [
        kind
        for kind in catalogue(package, path, ABCMeta, NO_INTEGRATORS)
        if issubclass(kind, Integrator) and kind.name and not isabstract(kind)
    ]
    for kind in classes:
        _check(kind)
    return classes


def named(kinds: Iterable[type[Integrator]]) -> dict[str, type[Integrator]]:
    """Return classes by name, sorted by `place`, then by name."""
    ordered = sorted(kinds, key=lambda kind: (kind.place, kind.name))
    return by_name([(kind.name, kind) for kind in ordered], "integrator")


def _check(kind: type[Integrator]) -> None:
    if not kind.meaning:
        raise ValueError(f"integrator {kind.name}: expected a `meaning`, half a line")
    if kind.takes not in FIRST_ARGUMENTS:
        raise ValueError(f"integrator {kind.name}: takes: expected one of {FIRST_ARGUMENTS}")
    if set(kind.treatments) - set(IMPLICIT):
        raise ValueError(f"integrator {kind.name}: treatments: expected some of {IMPLICIT}")
    known = _options(kind)
    for key in kind.keys:
        if key.name not in known:
            raise ValueError(f"integrator {kind.name}: key {key.name}: expected one of {known}")


def _options(kind: type[Any]) -> list[str]:
    """Return the options of a class and of those that it derives from."""
    codes = [getattr(vars(c).get("__init__"), "__code__", None) for c in kind.__mro__]
    return [n for c in codes if c for n in c.co_varnames[c.co_argcount :][: c.co_kwonlyargcount]]


_known = classes_of(_package, _path) + classes_of(
    f"{_package}.generic", [str(Path(__file__).parent / "generic")]
)
# Those of y' = f(t, y), and those of a mechanism, which take the place of others of their names.
FOR_EQUATIONS = named({kind for kind in _known if kind.takes == "derivative"})
INTEGRATORS = named(
    (FOR_EQUATIONS | named({kind for kind in _known if kind.takes == "model"})).values()
)


def new_integrator(
    name: str, f: Derivative, t0: float, y0: Array, t_end: float, **options: Any
) -> Integrator:
    """Make an integrator of y' = f(t, y) by name, ready to step.

    Parameters
    ----------
    name : name of the method
    f : right-hand side of y' = f(t, y)
    t0 : start [s]
    y0 : state at the start (n,)
    t_end : end [s]
    options : options of the method

    Raises
    ------
    ValueError : unknown name or option, with the nearest known one
    """
    if name not in FOR_EQUATIONS:
        raise ValueError(f"integrator: {_unknown(name, list(FOR_EQUATIONS))}")
    kind = FOR_EQUATIONS[name]
    known = _options(kind)
    for option in options:
        if option not in known:
            raise ValueError(f"integrator {name}, option: {_unknown(option, known)}")
    return kind(f, t0, y0, t_end, **options)


def _unknown(word: str, known: list[str]) -> str:
    return f"expected one of {', '.join(known)}, got {word!r}{did_you_mean(word, known)}"


EXAMPLES = 3  # integrators that a message names


def treatment_of(solver: Any) -> Treatment:
    """Return the treatment of constraints that `[solver]` of a case asks for.

    Raises
    ------
    InputError
        A treatment that the integrator does not support.
    """
    treatment, own = Treatment.of(solver), INTEGRATORS[solver.integrator].treatments
    possible = own or tuple(t for t in TREATMENTS if t not in IMPLICIT)
    if treatment.name not in possible:
        able = [name for name, kind in INTEGRATORS.items() if treatment.name in kind.treatments]
        others = [name for name, kind in INTEGRATORS.items() if not kind.treatments]
        wanted = (
            "integrator = " + " or ".join(f'"{name}"' for name in able)
            if treatment.name in IMPLICIT
            else "one that does not solve the constraints within the step "
            f"({', '.join(others[:EXAMPLES])} ...)"
        )
        raise InputError(
            f'solver.constraints = "{treatment.name}" with integrator = "{solver.integrator}": '
            f"expected {wanted}, or constraints = {' or '.join(possible)}"
        )
    return treatment
