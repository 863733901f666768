"""Signals: the requested quantities, computed from states at the output times."""

from .combined import Histories
from .recording import Recording
from .sensors import Sensor, fatigue_entry, recorded, sensors

__all__ = ["Histories", "Recording", "Sensor", "fatigue_entry", "recorded", "sensors"]
