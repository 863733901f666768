"""Positions and velocities that satisfy the constraints."""
