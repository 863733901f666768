"""Treatments of the constraint equations."""
