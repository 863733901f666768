"""Quadrilaterals: their membrane, and rotations inside their cells."""
