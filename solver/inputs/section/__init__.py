"""Descriptions of beam cross-sections."""
