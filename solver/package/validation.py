"""Validate a package or section file and report all errors."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py

from ..errors import InputError, PackageError
from .body.checks import content_findings, layout_findings
from .body.layout import MODAL_PACKAGE, MODAL_VIEW
from .body.plausibility import plausibility_findings
from .body.reader import load
from .body.schema import ModalPackage
from .body.writer import write_package
from .common.container import get_text, open_file
from .common.identity import FileFormat, checksum_findings, identity_notes, unit_findings
from .common.remark import Remark, raise_first
from .common.temporary import temporary_sibling
from .common.vtk_view import view_findings
from .section.checks import (
    section_content_findings,
    section_layout_findings,
    section_plausibility_findings,
)
from .section.io import load_section
from .section.layout import SECTION_FILE, SECTION_VIEW

__all__ = ["Remark", "validate", "write_valid"]

# Where a dataset of a package comes from.
PARTS = {
    "modes/mass": "its mass: ",
    "modes/stiffness": "its stiffness: ",
    "modes/damping": "its damping: ",
    "modes": "its modes: ",
    "invariants": "its mass and nodes: ",
    "nodal": "its masses of nodes: ",
    "interfaces": "its interfaces: ",
    "mesh": "its nodes and cells: ",
}
DATASET_ATTRIBUTES = ("unit", "frame", "description")


@dataclass(frozen=True)
class _Kind:
    """Checks of the files of one format, in this order."""

    format: FileFormat
    layout: Callable[[h5py.Group], list[Remark]]
    mesh: tuple[str, str]  # group of the mesh, its nodes
    load: Callable[[h5py.File], Any]
    content: Callable[[Any], list[Remark]]
    plausibility: Callable[[Any], list[Remark]]


_MODAL = _Kind(
    MODAL_PACKAGE,
    layout_findings,
    MODAL_VIEW,
    load,
    content_findings,
    plausibility_findings,
)
_SECTION = _Kind(
    SECTION_FILE,
    section_layout_findings,
    SECTION_VIEW,
    load_section,
    section_content_findings,
    section_plausibility_findings,
)


def validate(path: str | Path) -> list[Remark]:
    """Return all findings on a modal package or a section file; it is usable without an "error".

    Later stages require earlier ones: arrays of a wrong shape are not compared.
    A file of another format gives one finding.
    """
    path = Path(path)
    try:
        with open_file(path, PackageError) as file:
            section = get_text(file, "format") == SECTION_FILE.format
            kind = _SECTION if section else _MODAL
            findings = identity_notes(path, file, kind.format)
            layout = kind.layout(file[kind.format.group])
            findings += layout + _attributes(file, kind.format)
            findings += view_findings(file, *kind.mesh)
            findings += checksum_findings(file, kind.format, whole=True)
            if any(f.level == "error" for f in layout):
                return findings
            package = kind.load(file)
    except PackageError as error:
        return [Remark("error", "/", str(error).removeprefix(f"{path}: "))]
    content = kind.content(package)
    findings += content
    if not any(f.level == "error" for f in content):
        findings += kind.plausibility(package)
    return findings


def write_valid(path: Path, package: ModalPackage, source: str, *, own: bool = False) -> None:
    """Write a modal package that `validate` accepts; else nothing is written.

    Parameters
    ----------
    source : file that the package is made from, for the message
    own : whatever lies there is ours, as in build/CASE/bodies

    Raises
    ------
    InputError
        What `validate` would refuse, and which part of the source it comes from.
    """
    if path.suffix != ".vtkhdf":
        write_package(path, package)  # says so
    try:
        with temporary_sibling(path, own=own) as temporary:
            write_package(temporary, package)
            raise_first(temporary, validate(temporary))
    except PackageError as error:
        words = str(error).removeprefix(f"{temporary}: ").removeprefix("/modal_package/")
        part = next((text for name, text in PARTS.items() if words.startswith(name)), "")
        raise InputError(f"{source}: {part}no valid package is made of it: {words}") from error


def _attributes(file: h5py.File, known: FileFormat) -> list[Remark]:
    findings = []
    for name in (known.title, "units", "provenance"):
        if name not in file.attrs and name not in file:
            findings.append(Remark("warning", "/", f"attribute {name}: missing"))
    findings += unit_findings(file)

    without: dict[str, list[str]] = {}  # attributes -> datasets: one finding for all of them

    def visit(_: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            missing = [name for name in DATASET_ATTRIBUTES if name not in item.attrs]
            if missing:
                without.setdefault(", ".join(missing), []).append(item.name)

    file[known.group].visititems(visit)
    for names, datasets in without.items():
        others = f" here and in {len(datasets) - 1} other datasets" if len(datasets) > 1 else ""
        findings.append(Remark("warning", datasets[0], f"attribute {names}: missing{others}"))
    return findings
