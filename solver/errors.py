"""Errors in the input of the user: shown as one message, exit code 2."""

import contextlib
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

COMPILER = "DOLFINx needs a C compiler (gcc) and Python's headers (python3-dev)"
HOW_TO_INSTALL_FENICSX = """\
Run `make fenicsx` in a checkout to find or install FEniCSx, or install it by one of these lines:
  Debian, Ubuntu: apt-get install python3-dolfinx-real python3-slepc4py-real python3-gmsh \
python3-h5py python3-scipy gcc python3-dev
  conda: conda install -c conda-forge fenics-dolfinx 'petsc=*=*real*' slepc4py python-gmsh \
c-compiler h5py scipy"""


class InputError(Exception):
    """The input is wrong; the message names file, key, value and expectation."""


class PackageError(Exception):
    """A file of this project cannot be used; the message names file and dataset."""


def refuse(errors: Iterable[str]) -> None:
    """Raise InputError with one line for each finding, each once; return if there is none."""
    if lines := dict.fromkeys(errors):
        raise InputError("\n".join(lines))


@contextlib.contextmanager
def collected(errors: list[str]) -> Iterator[None]:
    """Add the lines of an InputError that is raised inside to `errors`."""
    try:
        yield
    except InputError as error:
        errors += str(error).splitlines()


def under(key: str, error: InputError) -> InputError:
    """Return the same error with a key before each of its lines: "bodies.arm.shell: ..."."""
    return InputError("\n".join(f"{key}: {line}" for line in str(error).splitlines()))


def printable(text: str) -> str:
    """Return a text in one line: control characters as escapes.

    For messages, and for comments in generated files, which a line break would end.
    """
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )


MOST_NAMED = 5


def few(texts: Iterable[str], separator: str = ", ", most: int = MOST_NAMED) -> str:
    """Return the first of some words, and how many more there are: "a, b, c, d, e and 12 more".

    Parameters
    ----------
    texts : the words
    separator : text between them
    most : number of words that are named
    """
    every = list(texts)
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return separator.join(every[:most]) + more


def counted(number: int, one: str, several: str = "") -> str:
    """Return a number with its noun, "1 body"; `several` of it are `one` with an s by default.

    Parameters
    ----------
    number : the number
    one : noun of one
    several : noun of several
    """
    return f"{number} {one if number == 1 else several or one + 's'}"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for the known word closest to `word`, or nothing."""
    from difflib import get_close_matches  # only of wrong input

    close = get_close_matches(word, sorted(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else ""


def check_keys(table: Any, known: tuple[str, ...], where: str, error: type[Exception]) -> None:
    """Raise `error` if this is not a table, or for its first unknown key, with the nearest one.

    Parameters
    ----------
    table : table of an input file
    known : keys that it may have
    where : path of the table, for messages
    error : class of the error
    """
    if not isinstance(table, Mapping):
        raise error(f"{where} = {table!r}: expected a table")
    for key in table:
        if key not in known:
            raise error(
                f"{where}.{key}: unknown key, expected {', '.join(known)}"
                + did_you_mean(str(key), known)
            )


def check_known(
    value: Any,
    known: Iterable[str],
    where: str,
    error: type[Exception],
    expectation: str | None = None,
) -> None:
    """Raise `error` for a value that is none of the known ones, with the nearest of them.

    Parameters
    ----------
    value : value at a key
    known : the values that it may have
    where : path of the key, for messages
    error : class of the error
    expectation : what was expected, in words; by default one of the known values
    """
    names = list(known)
    if value not in names:
        expectation = expectation or f"expected one of {', '.join(names)}"
        hint = did_you_mean(str(value), names)
        raise error(f"{where} = {value!r}: {expectation}{hint}")


def not_by_check(file: Path, what: str, cause: object) -> InputError:
    """Return the error of a file that is no `what` ("run file") of `plymotion check`.

    Parameters
    ----------
    file : the file that was read
    what : what was expected, as "run file"
    cause : error or text that says why it is none
    """
    if isinstance(cause, OSError):
        return InputError(f"{file}: {cause.strerror}; expected a {what} of `plymotion check`")
    why = f"no key {cause}" if isinstance(cause, KeyError) else cause
    if file.suffix == ".toml":
        why = f"a TOML file; of a case: `plymotion {file}`, for a sweep with --sweep NAME"
    return InputError(f"{file}: not a {what} ({why}); expected one written by `plymotion check`")


def coded(code: str, message: str) -> list[dict[str, str]]:
    """Return a list of one warning, as files of sections, shells and bodies have them."""
    return [{"code": code, "message": message}]


def nearest(name: str, known: Iterable[str], most: int = MOST_NAMED) -> str:
    """Return `did_you_mean`, or some known names if none is close.

    Parameters
    ----------
    name : name that is not known
    known : the known names
    most : number of known names that are named
    """
    names = sorted(known)
    listed = f"; known: {few(names, most=most)}" if names else "; none is defined"
    return did_you_mean(name, names) or listed


def unknown(key: str, name: str, what: str, known: Iterable[str]) -> list[str]:
    """Return the error of a name at a key that is not among the known ones, of a known one none.

    Parameters
    ----------
    key : key of the input file
    name : its value
    what : what the value names, as "joint"
    known : the known names
    """
    known = list(known)
    return [] if name in known else [f'{key} = "{name}": no such {what}{nearest(name, known)}']


# All but tabs, ends of lines, and the carriage return of a progress bar that is drawn again.
_CONTROL = re.compile(
    r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e]|(?<!^)\r(?!$)"
)


class _WithoutControl:
    """A text stream that writes control characters as escapes."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        self._stream.write(_CONTROL.sub(lambda m: m[0].encode("unicode_escape").decode(), text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def escape_control_characters() -> None:
    """Write control characters to the terminal as escapes, as of file names from elsewhere.

    A terminal would obey them: move the cursor, delete what was written, change its title.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if not isinstance(stream, _WithoutControl):
            setattr(sys, name, _WithoutControl(stream))
