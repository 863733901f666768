"""Error class of the shell analysis."""


class ShellError(Exception):
    """The description of a shell is wrong, or the shell cannot be analysed."""
