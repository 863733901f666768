"""Scripts that a description names: they run with the rights of the user, unless refused."""

import contextlib
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

from ..errors import InputError

SUFFIXES = (".geo", ".py")
_allowed: ContextVar[bool] = ContextVar("scripts_allowed", default=True)


@contextlib.contextmanager
def scripts(*, allowed: bool) -> Iterator[None]:
    """Allow or refuse scripts in the descriptions that are read inside."""
    token = _allowed.set(allowed)
    try:
        yield
    finally:
        _allowed.reset(token)


def are_refused() -> bool:
    """Tell whether scripts are refused, so that the preprocessor refuses them, too."""
    return not _allowed.get()


def refuse_script(file: Path, key: str) -> None:
    """Raise InputError for a script where scripts are refused; `key` names it in the message."""
    if file.suffix in SUFFIXES and not _allowed.get():
        raise InputError(
            f"{key}: expected no script with --no-scripts, it would run commands; a mesh .msh is "
            "only read"
        )
