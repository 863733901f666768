"""Modal packages from measured vibration modes (the paper, section 2.3)."""

from .measurement import Measurement, load_measurement
from .package import experimental_package, write_measured

__all__ = ["Measurement", "experimental_package", "load_measurement", "write_measured"]
