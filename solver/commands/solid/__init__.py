"""Solids: parts from CAD, their inertia, frequencies and load cases on the screen."""
