"""Designs: parameters of a case searched for the best value of a signal (docs/design.md)."""
