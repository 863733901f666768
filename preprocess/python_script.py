"""Scripts that make a mesh: import of Python files, and whether those of the user may run."""

import contextlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

SUFFIXES = (".geo", ".py")
_refused = False  # of the process: its threads build sections, too


@contextlib.contextmanager
def scripts(*, refused: bool) -> Iterator[None]:
    """Refuse mesh scripts of the user inside, or run them; those of the library always run."""
    global _refused
    before, _refused = _refused, refused
    try:
        yield
    finally:
        _refused = before


def is_refused(path: Path) -> bool:
    """Tell whether a file of the user is a script, and those are refused."""
    return _refused and path.suffix in SUFFIXES


def load_script(path: Path) -> ModuleType:
    """Import a file by its path."""
    spec = importlib.util.spec_from_file_location(f"plymotion_script_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
