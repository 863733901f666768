"""Signals: the requested quantities, computed from states at the output times."""

from ..dynamics.analysis.recovery import HELD, Recording
from .sensors import Histories, Sensor, Turns, fatigue_entry, recorded, sensors
