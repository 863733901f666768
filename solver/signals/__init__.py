"""Signals: the requested quantities, computed from states at the output times."""

from ..dynamics.analysis.recovery import Recording
from .sensors import Histories, Sensor, fatigue_entry, recorded, sensors
from .turns import Turns

__all__ = ["Histories", "Recording", "Sensor", "Turns", "fatigue_entry", "recorded", "sensors"]
