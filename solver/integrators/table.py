"""The integrators of this folder and of generic/ by their name in `[solver] integrator`."""

from ..dynamics.elements.constraints.treatment import IMPLICIT
from . import __name__ as _package
from . import __path__ as _path
from .generic.base import Integrator
from .generic.table import CLASSES, classes_of, named

_own = [
    kind
    for kind in classes_of(_package, _path, ("table", "choice", "generic"))
    if kind not in CLASSES
]
# A loop takes the place of the class for plain equations that has its name.
INTEGRATORS: dict[str, type[Integrator]] = named(
    [*_own, *(kind for kind in CLASSES if kind.name not in {own.name for own in _own})]
)

for _kind in INTEGRATORS.values():
    if set(_kind.treatments) - set(IMPLICIT):
        raise ValueError(f"integrator {_kind.name}: treatments: expected some of {IMPLICIT}")
