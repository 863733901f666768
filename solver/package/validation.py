"""Validate a package or section file and report all errors."""

from pathlib import Path
from typing import Any

import h5py

from ..errors import InputError, PackageError
from .body.package_file import MODAL_PACKAGE, write_package
from .body.package_schema import ModalPackage
from .common.container import contents, get_text, open_file
from .common.dataset import WORDS
from .common.design import GROUP
from .common.files import temporary_sibling
from .common.findings import Remark, raise_first
from .common.object_file import (
    PACKED,
    FileFormat,
    ObjectFormat,
    checksum_findings,
    identity_notes,
    unit_findings,
    write_packed,
)
from .section.section_file import SECTION_FILE

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


def validate(path: str | Path) -> list[Remark]:
    """Return all findings on a modal package or a section file; it is usable without an "error".

    Later stages require earlier ones: arrays of a wrong shape are not compared.
    A file of another format gives one finding.
    """
    path = Path(path)
    try:
        with open_file(path, PackageError) as file:
            section = get_text(file, "format") == SECTION_FILE.format
            known: ObjectFormat[Any] = SECTION_FILE if section else MODAL_PACKAGE
            findings = identity_notes(path, file, known)
            items = contents(file[known.group])
            layout = known.layout_findings(items)
            findings += layout + _attributes(file, known)
            findings += known.view_findings(file)
            findings += checksum_findings(file, known, whole=True)
            if any(f.level == "error" for f in layout):
                return findings
            package = known.load(items, known.kind)
    except PackageError as error:
        return [Remark("error", "/", str(error).removeprefix(f"{path}: "))]
    content = known.content(package)
    findings += content
    if not any(f.level == "error" for f in content):
        findings += known.doubts(package)
    return findings


def write_valid(path: Path, package: ModalPackage, source: str, *, own: bool = False) -> None:
    """Write a modal package that `validate` accepts; else nothing is written.

    A path with the ending `PACKED` is for another process of this program.

    Parameters
    ----------
    source : file that the package is made from, for the message
    own : the package, and whatever lies there, is ours, as in build/CASE/bodies

    Raises
    ------
    InputError
        What `validate` would refuse, and which part of the source it comes from.
    """
    if path.suffix not in (".vtkhdf", PACKED):
        write_package(path, package)  # says so
    try:
        with temporary_sibling(path, own=own) as temporary:
            # both compare numbers with each other
            if path.suffix == PACKED:
                write_packed(temporary, MODAL_PACKAGE, package)
            else:
                write_package(temporary, package)
            # what this program computed is not read again
            remarks = list(MODAL_PACKAGE.doubts(package)) if own else validate(temporary)
            raise_first(temporary, remarks)
    except PackageError as error:
        message = str(error).removeprefix(f"{temporary}: ").removeprefix("/modal_package/")
        part = next((text for name, text in PARTS.items() if message.startswith(name)), "")
        raise InputError(f"{source}: {part}no valid package is made of it: {message}") from error


def _attributes(file: h5py.File, known: FileFormat) -> list[Remark]:
    findings = []
    for name in (known.title, "units", "provenance"):
        if name not in file.attrs and name not in file:
            findings.append(Remark("warning", "/", f"attribute {name}: missing"))
    findings += unit_findings(file)

    derivatives = f"/{known.group}/{GROUP}/"
    without: dict[str, list[str]] = {}  # attributes -> datasets: one finding for all of them

    def visit(_: str, item: h5py.HLObject) -> None:
        # derivatives have the words of their datasets
        if isinstance(item, h5py.Dataset) and not item.name.startswith(derivatives):
            missing = [name for name in WORDS if name not in item.attrs]
            if missing:
                without.setdefault(", ".join(missing), []).append(item.name)

    file[known.group].visititems(visit)
    for names, datasets in without.items():
        others = f" here and in {len(datasets) - 1} other datasets" if len(datasets) > 1 else ""
        findings.append(Remark("warning", datasets[0], f"attribute {names}: missing{others}"))
    return findings
