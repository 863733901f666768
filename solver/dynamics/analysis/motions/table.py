"""The motions of this folder by kind."""

from ....math.catalogue import by_name, catalogue
from . import __name__ as _package
from . import __path__ as _path
from .contract import Motion

_found = catalogue(_package, _path, Motion, ("table",))
MOTIONS = by_name(
    [(m.kind, m) for m in sorted(_found, key=lambda m: (m.order, m.kind))], "motion of a place"
)
