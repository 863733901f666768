"""The sections of a batch: a folder, a pattern, a list, or a study."""

import glob
from pathlib import Path

from ...errors import InputError
from ...inputs.common import read_toml
from ...inputs.section.study import study_variants
from ..described.entries import Entry, entries_of


def read_list(place: str) -> list[Entry]:
    """Read a batch list.

    Parameters
    ----------
    place : a folder of descriptions (*.toml), a pattern such as "sections/box-*.toml", a study
        (see study.py), or a text file with the name of a description in each line, relative to its
        folder; `#` starts a comment

    Raises
    ------
    InputError : it does not exist, names no section, or is wrong.
    """
    path = Path(place)
    if path.is_dir():
        found = entries_of(sorted(path.glob("*.toml")))
    elif glob.has_magic(place):
        found = entries_of(Path(name) for name in sorted(glob.glob(place, recursive=True)))
    elif path.suffix == ".toml":
        found = _study_entries(path)
    else:
        found = entries_of(path.parent / name for name in _names(path))
    if not found:
        raise InputError(f"{place}: names no section; expected descriptions (*.toml)")
    return found


def _names(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding="utf-8")
    except (FileNotFoundError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: not a batch list; expected folder, pattern, study (.toml) or text file"
        ) from error
    return [name for line in text.splitlines() if (name := line.split("#")[0].strip())]


def _study_entries(path: Path) -> list[Entry]:
    table = read_toml(path, "batch list")
    if "mesh" in table:
        raise InputError(f"{path}: this is a section description: use it without --batch")
    study, variants = study_variants(path, table)
    return [
        Entry(base.name + suffix, base.file, changes)
        for base in entries_of(path.parent / name for name in study.sections)
        for suffix, changes in variants
    ]
