"""Signals: the requested quantities, computed from states at the output times."""

from .recording import Recording
from .sensors import Sensor, recorded, sensors

__all__ = ["Recording", "Sensor", "recorded", "sensors"]
