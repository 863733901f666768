"""All drivers by name."""

from importlib import import_module
from types import ModuleType

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


def library(name: str, extra: str) -> ModuleType:
    """Return the library of a driver. Raises InputError with the line that installs it."""
    try:
        return import_module(name)
    except ImportError as error:
        raise InputError(
            f"driver {extra}: needs {name} ({error}): pip install 'plymotion[{extra}]'"
        ) from error
