"""Beams: a two-node Timoshenko element from any full 6x6 section stiffness."""
