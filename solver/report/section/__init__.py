"""Beam cross-sections without FEniCSx: description, command line, figures, conventions."""
