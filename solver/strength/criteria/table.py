"""The criteria of this folder, and the selection of those for a material."""

from ...math.catalogue import by_name, catalogue
from ...package.common.materials import PlyStrength, YieldStrength
from . import __name__ as _package
from . import __path__ as _path
from .contract import Criterion

_found = catalogue(_package, _path, Criterion, besides=("table",))
CRITERIA = by_name(
    [(c.name, c) for c in sorted(_found, key=lambda c: (c.order, c.name))], "criterion"
)


def criteria_of(strength: PlyStrength | YieldStrength) -> tuple[Criterion, ...]:
    """Return the criteria that apply to a material of these strengths."""
    return tuple(c for c in CRITERIA.values() if isinstance(strength, c.strength))
