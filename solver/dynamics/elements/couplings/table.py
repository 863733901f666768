"""The couplings of this folder by name."""

from ....math.catalogue import by_name, catalogue
from . import __name__ as _package
from . import __path__ as _path
from .contract import Coupling

COUPLINGS: dict[str, Coupling] = by_name(
    [
        (found.kind, found)
        for found in sorted(
            catalogue(_package, _path, Coupling, ("table",)), key=lambda c: (c.order, c.kind)
        )
    ],
    "coupling",
)
