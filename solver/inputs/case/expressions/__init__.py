"""Expressions of a case, and the laws of time of its joints and forces."""
