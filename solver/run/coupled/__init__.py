"""A run that another program moves on: it writes inputs, asks for a time, and reads outputs."""

from .stepper import Stepper

__all__ = ["Stepper"]
