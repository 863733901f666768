"""All drivers by name."""

from ....errors import InputError, nearest
from ....math.catalogue import by_name, catalogue
from . import __name__ as package
from . import __path__ as path
from .contract import Driver

DRIVERS = by_name(
    ((d.name, d) for d in catalogue(package, path, Driver, besides=("table", "contract"))), "driver"
)


def driver_of(name: str, where: str) -> Driver:
    """Return a driver. Raises InputError; `where` names file and study."""
    if name not in DRIVERS:
        raise InputError(f'{where}.driver = "{name}": no such driver{nearest(name, DRIVERS)}')
    return DRIVERS[name]
