"""Error classes of the section analysis."""


class SectionError(Exception):
    """The description of a cross-section is wrong, or the section cannot be analysed."""


class IllConditioned(Exception):
    """The equations need other unknowns; they are not solved with these."""
