"""Figures of a section."""
