"""Flexible bodies of a case: their specifications and their checks."""
