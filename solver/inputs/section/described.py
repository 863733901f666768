"""The specification of a section that is described in TOML or in the input of another code."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..common import read_toml
from .codes.other_codes import is_of_another_code, spec_of_another_code
from .expand import section_spec
from .study import changed


def described_spec(
    file: Path, changes: Mapping[str, Any], name: str, folder: Path
) -> dict[str, Any]:
    """Return the specification of a description with changes.

    Parameters
    ----------
    changes : other values at dotted keys
    name : of the section if there are changes
    folder : where meshes of the description are written

    Raises
    ------
    InputError : the description or a change is wrong.
    """
    if is_of_another_code(file) and not changes:
        return spec_of_another_code(file, folder)
    table = read_toml(file, "section description")
    if not changes:
        return section_spec(table, file, folder)
    try:
        spec = section_spec(changed(table, changes, file), file, folder)
    except InputError as error:
        found = str(error).splitlines()
        raise InputError("\n".join(f"{name}: {line}" for line in found)) from error
    return spec | {"name": name}
