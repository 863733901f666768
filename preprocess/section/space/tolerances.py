"""Limits of meshes of cross-sections.

tests/fe/test_section_layers.py::test_edges_between_two_sides_stay_straight fails without them.
"""

# Of the length of an edge: distances that are round-off of coordinates.
STRAIGHT = 1e-9
# As far is the middle of an edge of 45 deg from its chord. Farther is the depth of edges between
# two sides of a section, which has no slope in the middle.
BOWED = 0.1
