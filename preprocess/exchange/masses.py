"""Masses of nodes as a table, beside formats that have modes only."""

from pathlib import Path

from ...solver.package import ModalPackage
from ...solver.package.common.temporary import temporary_sibling

PARTS = {"Jxx": (0, 0), "Jyy": (1, 1), "Jzz": (2, 2), "Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}


def write_masses(package: ModalPackage, out: Path) -> Path:
    """Write node, mass [kg] and inertia [kg m2] as CSV beside `out`; returns the file."""
    file = out.with_name(f"{out.stem}_masses.csv")
    lines = [",".join(["node", "mass", *PARTS])]
    for label, m, J in zip(
        package.node_ids, package.node_mass, package.node_inertia_B, strict=True
    ):
        values = [m, *(J[part] for part in PARTS.values())]
        lines.append(",".join([str(label), *(f"{value:.17g}" for value in values)]))
    with temporary_sibling(file) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file
