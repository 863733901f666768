"""Checks of a case beyond types and bounds."""
