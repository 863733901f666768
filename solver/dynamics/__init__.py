"""Equations of motion of a mechanism: bodies, joints, forces, constraints and their solution."""
