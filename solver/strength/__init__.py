"""Failure criteria of plies and metals, and where bodies come nearest to failure."""

from .criteria.contract import Criterion
from .criteria.ray import Verdict
from .criteria.table import CRITERIA, PLY_CRITERIA, YIELD_CRITERIA, criteria_of

__all__ = ["CRITERIA", "PLY_CRITERIA", "YIELD_CRITERIA", "Criterion", "Verdict", "criteria_of"]
