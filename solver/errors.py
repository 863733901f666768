"""Errors in the input of the user: shown as one message, exit code 2."""

from collections.abc import Iterable
from difflib import get_close_matches


class InputError(Exception):
    """The input is wrong; the message names file, key, value and expectation."""


class PackageError(Exception):
    """A file of this project cannot be used; the message names file and dataset."""


def under(key: str, error: InputError) -> InputError:
    """Return the same error with a key before each of its lines: "bodies.arm.shell: ..."."""
    return InputError("\n".join(f"{key}: {line}" for line in str(error).splitlines()))


MOST_NAMED = 5


def few(words: Iterable[str], separator: str = ", ") -> str:
    """Return the first of some words, and how many more there are: "a, b, c, d, e and 12 more"."""
    every = list(words)
    more = f" and {len(every) - MOST_NAMED} more" if len(every) > MOST_NAMED else ""
    return separator.join(every[:MOST_NAMED]) + more


def counted(number: int, one: str, several: str = "") -> str:
    """Return a number with its noun, "1 body"; `several` of it are `one` with an s by default."""
    return f"{number} {one if number == 1 else several or one + 's'}"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for the known word closest to `word`, or nothing."""
    close = get_close_matches(word, sorted(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else ""


def nearest(name: str, known: Iterable[str]) -> str:
    """Return `did_you_mean`, or some known names if none is close."""
    names = sorted(known)
    listed = f"; known: {few(names)}" if names else "; none is defined"
    return did_you_mean(name, names) or listed
