"""Imported bodies: their import file, and hashes of the files of the other code."""

import os
from pathlib import Path
from typing import Any

from ...errors import InputError, nearest, under
from ...math.digests import file_sha256
from ...package.body.specification import ImportedSpecification
from ..common import read_toml
from .body_schema import ImportedBody


def imported_spec(
    name: str, body: ImportedBody, folder: Path
) -> tuple[ImportedSpecification, list[Path]]:
    """Return the specification of an imported body, and the files that it is made from.

    The preprocessor checks the keys of the import file.

    Parameters
    ----------
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        The import file or a file that it names is missing.
    """
    key = f'bodies.{name}.import = "{body.file}"'
    file = folder / body.file
    try:
        table = read_toml(file, "import file")
    except InputError as error:
        raise under(key, error) from error
    paths = _files(table, file, key)
    spec: ImportedSpecification = {
        "body": name,
        "kind": "imported",
        "file": os.path.relpath(file),
        "table": table,
        "sha256": {name: file_sha256(path) for name, path in paths.items()},
    }
    return spec, [file, *paths.values()]


def _files(table: dict[str, Any], file: Path, key: str) -> dict[str, Path]:
    """Files that the import file names, and those of the same stem beside a deck."""
    named = table.get("files")
    if not isinstance(named, dict) or not all(isinstance(v, str) for v in named.values()):
        raise InputError(f"{key}: files = {named!r}: expected a table of paths")
    found = {}
    for word, name in named.items():
        path = file.parent / name
        if not path.is_file():
            listed = [item.name for item in path.parent.glob("*")] if path.parent.is_dir() else []
            hint = nearest(path.name, listed)
            raise InputError(f"{key}: files.{word} = {name!r}: no such file{hint}")
        found[name] = path
        if word == "deck":
            beside = [path.with_suffix(suffix) for suffix in (".sti", ".mas", ".dof")]
            found |= {item.name: item for item in beside if item.is_file()}
    return found
