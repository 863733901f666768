"""Beam cross-sections on the light side: description, command line, figures, conventions."""
