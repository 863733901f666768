"""Sweeps: the members of an ensemble, computed, kept and shown (docs/sweeps.md)."""
