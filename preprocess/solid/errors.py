"""Error class of the solid analysis."""


class SolidError(Exception):
    """The description of a solid is wrong, or the solid cannot be analysed."""
