"""The error of this part of the preprocessor."""


class SectionError(Exception):
    """A cross-section that is described wrongly or cannot be analysed."""
