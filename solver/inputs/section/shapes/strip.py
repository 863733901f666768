"""Strip: a rectangle by another name."""

from dataclasses import replace

from .rectangle import SHAPE as RECTANGLE

SHAPE = replace(RECTANGLE, name="strip", meaning="a rectangle by another name", order=2)
