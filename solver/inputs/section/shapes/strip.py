"""Strip: another name for the rectangle."""

from dataclasses import replace

from .rectangle import SHAPE as RECTANGLE

SHAPE = replace(RECTANGLE, name="strip", meaning="another name for the rectangle", order=2)
