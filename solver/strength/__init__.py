"""Failure criteria of plies and metals, and the lowest strength ratio of a body."""

from .criteria.contract import Criterion, Verdict
from .criteria.table import CRITERIA, criteria_of
