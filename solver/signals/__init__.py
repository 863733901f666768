"""Signals: the requested quantities, computed from states at the output times."""

from ..dynamics.analysis.recovery import Recording
from .combined import Histories
from .sensors import Sensor, fatigue_entry, recorded, sensors
from .turns import Turns

__all__ = ["Histories", "Recording", "Sensor", "Turns", "fatigue_entry", "recorded", "sensors"]
