"""Sections in the input files of other codes, found by the name of the file or folder."""

from pathlib import Path
from typing import Any

from .becas_input import is_becas, read_becas
from .per_cell import cell_section_spec
from .vabs_input import read_vabs

VABS = (".dat", ".sg", ".vab", ".vabs")  # suffixes of VABS input


def is_of_another_code(file: Path) -> bool:
    """Return True for a VABS input file and for a folder of BECAS input."""
    return is_becas(file) or (file.suffix.lower() in VABS and file.is_file())


def spec_of_another_code(file: Path, folder: Path) -> dict[str, Any]:
    """Return the specification of a section of another code; arrays are written to a folder.

    Raises
    ------
    InputError
        The file is not what it should be.
    """
    section = read_becas(file) if is_becas(file) else read_vabs(file)
    return cell_section_spec(section, folder)
