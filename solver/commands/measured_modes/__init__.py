"""Measured modes of vibration as a modal package, which the paper (2.3) allows."""

from .measurement import Measurement, load_measurement
from .package import experimental_package

__all__ = ["Measurement", "experimental_package", "load_measurement"]
