"""Read a modal package and refuse what the solver could not rely on (docs/format.md)."""

import json
import warnings
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .checks import Finding, content_findings, layout_findings, raise_first
from .container import as_text, content_sha256, get_text, kind_of_file, open_file
from .layout import BODY_LAYOUT, GROUP, INTERFACE_LAYOUT, SECTION_LAYOUT, DatasetSpec
from .schema import (
    FORMAT,
    FORMAT_VERSION,
    Interface,
    Invariants,
    ModalPackage,
    PackageError,
    SectionData,
)


def read_package(path: str | Path) -> ModalPackage:
    """Read a modal package and check that the solver can rely on it.

    A newer minor version of the format gives a warning only.

    Raises
    ------
    PackageError
        When the file is missing, truncated, foreign, newer, incomplete,
        altered, or its numbers cannot be used; names file and dataset.
    """
    path = Path(path)
    with open_file(path, PackageError) as file:
        for note in identity_notes(path, file):
            warnings.warn(note.message, UserWarning, stacklevel=2)
        raise_first(path, layout_findings(file[GROUP]))
        raise_first(path, checksum_findings(file))
        package = load(file)
    raise_first(path, content_findings(package))
    return package


def identity_notes(path: Path, file: h5py.File) -> list[Finding]:
    """Check that this is a package whose version we know. Raises PackageError."""
    found = get_text(file, "format")
    if found != FORMAT:
        what = f"{found!r}" if found else kind_of_file(file)
        raise PackageError(f"{path}: attribute format: expected {FORMAT!r}, this is {what}")
    try:
        major, minor = (int(v) for v in np.ravel(file.attrs["format_version"]))
    except (KeyError, ValueError, TypeError):
        raise PackageError(f"{path}: attribute format_version: expected [major, minor]") from None
    if major != FORMAT_VERSION[0]:
        age = "a newer" if major > FORMAT_VERSION[0] else "an older"
        raise PackageError(
            f"{path}: written by {age} Plymotion: format {major}.{minor}, "
            f"this reader knows {FORMAT_VERSION[0]}.x"
        )
    if GROUP not in file:
        raise PackageError(f"{path}: /{GROUP}: missing group")
    if minor <= FORMAT_VERSION[1]:
        return []
    known = ".".join(map(str, FORMAT_VERSION))
    text = f"{path}: format {major}.{minor} is newer than {known}: parts of it are not read"
    return [Finding("warning", "format_version", text)]


def checksum_findings(file: h5py.File) -> list[Finding]:
    """Compare the content with the checksum the writer left."""
    stored = get_text(file, "content_sha256")
    if not stored:
        return [Finding("warning", "content_sha256", "no checksum: damage goes unnoticed")]
    actual = content_sha256(file[GROUP], get_text(file, "body"), get_text(file, "units"))
    if actual == stored:
        return []
    text = f"content was altered after writing: expected {stored[:12]}..., found {actual[:12]}..."
    return [Finding("error", "content_sha256", text)]


def load(file: h5py.File) -> ModalPackage:
    """Read all arrays of a file whose layout has been checked."""
    group = file[GROUP]
    data = {s.path: _read(group[s.path], s) for s in BODY_LAYOUT if s.path in group}
    invariants = {
        s.path.split("/")[1]: data[s.path] for s in BODY_LAYOUT if s.path.startswith("invariants/")
    }
    invariants["mass"] = float(invariants["mass"])
    return ModalPackage(
        body=get_text(file, "body"),
        nodes_B=data["mesh/nodes_B"],
        node_ids=data["mesh/node_ids"],
        connectivity=data["mesh/connectivity"],
        offsets=data["mesh/offsets"],
        cell_types=data["mesh/cell_types"].astype(np.int64),
        shapes_B=data["modes/shapes_B"],
        mode_kinds=data["modes/kinds"],
        frequencies=data["modes/frequencies"],
        mass=data["modes/mass"],
        stiffness=data["modes/stiffness"],
        damping=data["modes/damping"],
        node_mass=data["nodal/mass"],
        node_inertia_B=data["nodal/inertia_B"],
        invariants=Invariants(
            **invariants, mass_form=get_text(group["invariants"], "mass_form", "consistent")
        ),
        interfaces=tuple(
            Interface(
                name=g.name.rsplit("/", 1)[1],
                kind=get_text(g, "kind", "node"),
                **{s.path: _read(g[s.path], s) for s in INTERFACE_LAYOUT},
            )
            for g in _ordered(group, "interfaces")
        ),
        reference_condition=get_text(group, "reference_condition"),
        sections=tuple(
            SectionData(
                name=g.name.rsplit("/", 1)[1],
                **{s.path: _read(g[s.path], s) for s in SECTION_LAYOUT},
            )
            for g in _ordered(group, "sections")
        ),
        mode_labels=data.get("modes/labels", ()),
        provenance=_provenance(file),
    )


def _ordered(group: h5py.Group, parent: str) -> list[h5py.Group]:
    members = list(group[parent].values()) if parent in group else []
    return sorted(members, key=lambda g: int(g.attrs.get("index", 0)))


def _read(dataset: h5py.Dataset, spec: DatasetSpec) -> Any:
    if spec.type != "text":
        return np.asarray(dataset[()], dtype=spec.type)[()]
    if not spec.shape:
        return as_text(dataset[()])
    return tuple(as_text(text) for text in dataset[()])


def _provenance(file: h5py.File) -> dict[str, Any]:
    try:
        found = json.loads(get_text(file, "provenance", "{}"))
    except json.JSONDecodeError as cause:
        raise PackageError(f"{file.filename}: attribute provenance: not JSON: {cause}") from cause
    return found if isinstance(found, dict) else {"provenance": found}
