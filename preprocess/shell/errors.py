"""The error of this part of the preprocessor."""


class ShellError(Exception):
    """A shell that is described wrongly or cannot be analysed."""
