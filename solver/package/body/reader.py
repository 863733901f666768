"""Read a modal package and reject files that the solver cannot use (docs/format.md)."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..common.container import get_text
from ..common.dataset import DatasetSpec, read_datasets
from ..common.identity import json_table
from ..common.object_file import read_object_file
from ..common.remark import Remark, raise_first
from ..section.recovery_data import RECOVERY_LAYOUT, recovery_from
from .checks import content_findings, layout_findings
from .laminate_data import (
    CELL_LAYOUT,
    LAMINATE_LAYOUT,
    CellResultants,
    LaminateData,
    laminate_from,
)
from .layout import (
    BODY_LAYOUT,
    BODY_RECOVERY_LAYOUT,
    GROUP,
    INTERFACE_LAYOUT,
    MODAL_PACKAGE,
    MODAL_VIEW,
    SECTION_LAYOUT,
)
from .plausibility import plausibility_findings
from .schema import BodyRecovery, Interface, Invariants, ModalPackage, SecondOrder, SectionData
from .second_order import INTERFACE_SECOND_ORDER_LAYOUT, SECOND_ORDER_LAYOUT


def read_package(path: str | Path, *, allow_doubtful: bool = False) -> ModalPackage:
    """Read a modal package and check that the solver can use it.

    A newer minor version of the format gives a warning only. What `validate` calls an error is an
    error here.

    Parameters
    ----------
    allow_doubtful : numbers that can be computed with but contradict each other become warnings
        in the package's provenance

    Raises
    ------
    PackageError
        The file is missing, truncated, newer, incomplete, altered or of another format, or
        its numbers cannot be used; names file and dataset.
    """
    return read_object_file(
        path,
        MODAL_PACKAGE,
        layout_findings,
        load,
        content_findings,
        MODAL_VIEW,
        plausibility_findings,
        _warn if allow_doubtful else None,
    )


def _warn(package: ModalPackage, doubts: list[Remark]) -> None:
    stiffness = [d for d in doubts if d.dataset == f"/{GROUP}/modes/stiffness"]
    raise_first(Path(package.body), stiffness)  # no step can be taken with it
    warnings = package.provenance.setdefault("warnings", [])
    warnings += [
        {"code": "package-doubtful", "message": f"{d.dataset}: {d.message}"} for d in doubts
    ]


def load(file: h5py.File) -> ModalPackage:
    """Read all arrays of a file with a checked layout."""
    group = file[GROUP]
    data = read_datasets(group, BODY_LAYOUT)
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
                **read_datasets(g, (*INTERFACE_LAYOUT, *INTERFACE_SECOND_ORDER_LAYOUT)),
            )
            for g in _ordered(group, "interfaces")
        ),
        reference_condition=get_text(group, "reference_condition"),
        sections=tuple(_section(file, g) for g in _ordered(group, "sections")),
        recovery=_body_recovery(group),
        laminates=tuple(_laminate(file, g) for g in _ordered(group, "laminates")),
        cell_resultants=_cell_resultants(group),
        mode_labels=data.get("modes/labels", ()),
        second_order=_second_order(group),
        provenance=json_table(
            f"{file.filename}: attribute provenance", get_text(file, "provenance", "{}")
        ),
    )


def _second_order(group: h5py.Group) -> SecondOrder | None:
    if "second_order" not in group:
        return None
    return SecondOrder(**_by_name(group, SECOND_ORDER_LAYOUT))


def _section(file: h5py.File, group: h5py.Group) -> SectionData:
    recovery = None
    if "recovery" in group:
        data = read_datasets(group, RECOVERY_LAYOUT)
        recovery = recovery_from(data, f"{file.filename}: {group.name}")
    return SectionData(
        name=group.name.rsplit("/", 1)[1],
        recovery=recovery,
        **read_datasets(group, SECTION_LAYOUT),
    )


def _body_recovery(group: h5py.Group) -> BodyRecovery | None:
    if "recovery" not in group:
        return None
    return BodyRecovery(**_by_name(group, BODY_RECOVERY_LAYOUT))


def _laminate(file: h5py.File, group: h5py.Group) -> LaminateData:
    data = read_datasets(group, LAMINATE_LAYOUT)
    name = group.name.rsplit("/", 1)[1]
    return laminate_from(name, data, f"{file.filename}: {group.name}")


def _cell_resultants(group: h5py.Group) -> CellResultants | None:
    if "cell_resultants" not in group:
        return None
    return CellResultants(**_by_name(group, CELL_LAYOUT))


def _by_name(group: h5py.Group, layout: tuple[DatasetSpec, ...]) -> dict[str, Any]:
    """Values by the last part of their path."""
    return {path.rsplit("/", 1)[-1]: value for path, value in read_datasets(group, layout).items()}


def _ordered(group: h5py.Group, parent: str) -> list[h5py.Group]:
    members = list(group[parent].values()) if parent in group else []
    return sorted(members, key=lambda g: int(g.attrs.get("index", 0)))
