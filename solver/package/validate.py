"""Examine a package file and report everything that is wrong with it."""

from pathlib import Path

import h5py
import numpy as np

from .checks import Finding, content_findings, layout_findings
from .container import get_text, open_file
from .layout import GROUP
from .plausibility import plausibility_findings
from .reader import checksum_findings, identity_notes, load
from .schema import PackageError

__all__ = ["Finding", "validate"]

DATASET_ATTRIBUTES = ("unit", "frame", "description")


def validate(path: str | Path) -> list[Finding]:
    """Return every finding on a modal package; none of level "error" means it is usable.

    Later stages need the earlier ones: arrays of a wrong shape are not compared.
    A file that is no package at all gives one finding.
    """
    path = Path(path)
    try:
        with open_file(path, PackageError) as file:
            findings = identity_notes(path, file)
            layout = layout_findings(file[GROUP])
            findings += layout + _attributes(file) + _view(file) + checksum_findings(file)
            if any(f.level == "error" for f in layout):
                return findings
            package = load(file)
    except PackageError as error:
        return [Finding("error", "/", str(error))]
    content = content_findings(package)
    findings += content
    if not any(f.level == "error" for f in content):
        findings += plausibility_findings(package)
    return findings


def _attributes(file: h5py.File) -> list[Finding]:
    findings = []
    for name in ("body", "units", "provenance"):
        if name not in file.attrs:
            findings.append(Finding("warning", "/", f"attribute {name}: missing"))
    units = get_text(file, "units", "SI")
    if units != "SI":
        text = f"attribute units: expected 'SI', found {units!r}"
        findings.append(Finding("error", "/", text))

    def visit(_: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            missing = [name for name in DATASET_ATTRIBUTES if name not in item.attrs]
            if missing:
                text = f"attribute {', '.join(missing)}: missing"
                findings.append(Finding("warning", item.name, text))

    file[GROUP].visititems(visit)
    return findings


def _view(file: h5py.File) -> list[Finding]:
    """Check that what ParaView shows is what the solver reads."""
    view = file.get("VTKHDF")
    if not isinstance(view, h5py.Group):
        return [Finding("warning", "/VTKHDF", "missing: ParaView cannot open the file")]
    mesh = file[GROUP].get("mesh", {})
    pairs = (("Points", "nodes_B"), ("Connectivity", "connectivity"))
    findings = []
    for name, ours in (*pairs, ("Offsets", "offsets"), ("Types", "cell_types")):
        if name not in view:
            findings.append(Finding("warning", f"/VTKHDF/{name}", "missing"))
        elif ours in mesh and not np.array_equal(view[name][()], mesh[ours][()]):
            text = f"differs from /{GROUP}/mesh/{ours}"
            findings.append(Finding("error", f"/VTKHDF/{name}", text))
    return findings
