"""Error class of the section analysis."""


class SectionError(Exception):
    """The description of a cross-section is wrong, or the section cannot be analysed."""
