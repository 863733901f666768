"""Mesh and modes as a MED 3 file (code_aster, SALOME), by h5py: read and written.

Modes are the field DEPL, whose times are frequencies [Hz].
"""

from pathlib import Path

import h5py
import numpy as np

from ....solver.errors import InputError, nearest, printable
from ....solver.package import ModalPackage
from ....solver.package.common.container import written_through
from ....solver.package.common.files import DiskFile, temporary_sibling
from ..free_body import Cells, ModalBody
from ..import_table import Files

# VTK type -> name in MED, and the nodes of VTK in the order of MED. The solids of MED are mirrored:
# their first face, seen from inside, turns the other way.
MED_CELLS: dict[int, tuple[str, list[int]]] = {
    1: ("PO1", [0]),
    3: ("SE2", [0, 1]),
    21: ("SE3", [0, 1, 2]),
    5: ("TR3", [0, 1, 2]),
    22: ("TR6", [0, 1, 2, 3, 4, 5]),
    9: ("QU4", [0, 1, 2, 3]),
    23: ("QU8", [0, 1, 2, 3, 4, 5, 6, 7]),
    10: ("TE4", [0, 2, 1, 3]),
    24: ("T10", [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]),
    12: ("HE8", [0, 3, 2, 1, 4, 7, 6, 5]),
    25: ("H20", [0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17]),
    13: ("PE6", [0, 2, 1, 3, 5, 4]),
    26: ("P15", [0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13]),
}
NO_PROFILE = "MED_NO_PROFILE_INTERNAL"
MESH_STEP = "-0000000000000000001-0000000000000000001"
FIELD = "DEPL"
COMPONENTS = ("DX", "DY", "DZ", "DRX", "DRY", "DRZ")
SUFFIX = ".med"
BLANK = np.bytes_(" ")


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write the file: field DEPL, one time step per mode, whose time is the frequency [Hz].

    The labels of the nodes are kept (NUM). Returns a remark.

    Parameters
    ----------
    package, out, source : see contract.py
    """
    ascii_name = printable(package.body).encode("ascii", "replace").decode()
    name = ascii_name.replace("/", "-")[:64].strip(".") or "body"  # of a group of HDF5, too
    with (
        temporary_sibling(out) as temporary,
        DiskFile(temporary) as disk,
        written_through(disk) as file,
    ):
        file.create_group("INFOS_GENERALES").attrs.update({"MAJ": 3, "MIN": 0, "REL": 0})
        _mesh(file, package, name)
        _field(file, package, name)
    left_out = sorted(set(package.cell_types.tolist()) - set(MED_CELLS))
    remark = f"mesh {name!r}, {package.n_mode} modes in the field {FIELD}"
    return remark + (f"; cells of the VTK types {left_out} are left out" if left_out else "")


def _mesh(file: h5py.File, package: ModalPackage, name: str) -> None:
    mesh = file.create_group(f"ENS_MAA/{name}")
    mesh.attrs.update({"DIM": 3, "ESP": 3, "REP": 0, "SRT": 1, "TYP": 0})
    mesh.attrs.update({"UNT": BLANK, "UNI": np.bytes_(f"{'m':<16}" * 3)})
    mesh.attrs["NOM"] = np.bytes_("".join(f"{axis:<16}" for axis in "XYZ"))
    mesh.attrs["DES"] = np.bytes_("Plymotion modal package")
    step = mesh.create_group(MESH_STEP)
    step.attrs.update({"CGT": 1, "NDT": -1, "NOR": -1, "PDT": -1.0})
    nodes = step.create_group("NOE")
    nodes.attrs.update({"CGT": 1, "CGS": 1, "PFL": np.bytes_(NO_PROFILE)})
    _counted(nodes, "COO", package.nodes_B.ravel(order="F"), len(package.nodes_B))
    _counted(nodes, "NUM", package.node_ids, len(package.node_ids))
    groups = step.create_group("MAI")
    groups.attrs["CGT"] = 1
    cells = Cells(package.connectivity, package.offsets, package.cell_types).each()
    for kind, (title, order) in MED_CELLS.items():
        rows = [cell[order] for own, cell in cells if own == kind]
        if rows:
            group = groups.create_group(title)
            group.attrs.update({"CGT": 1, "CGS": 1, "PFL": np.bytes_(NO_PROFILE)})
            _counted(group, "NOD", np.array(rows).ravel(order="F") + 1, len(rows))
    file.create_group(f"FAS/{name}/FAMILLE_ZERO").attrs["NUM"] = 0


def _counted(group: h5py.Group, name: str, values: np.ndarray, count: int) -> None:
    group.create_dataset(name, data=values).attrs.update({"CGT": 1, "NBR": count})


def _field(file: h5py.File, package: ModalPackage, name: str) -> None:
    field = file.create_group(f"CHA/{FIELD}")
    field.attrs.update({"MAI": np.bytes_(name), "TYP": 6, "NCO": 6, "UNT": np.bytes_("Hz")})
    field.attrs["UNI"] = np.bytes_("".join(f"{unit:<16}" for unit in ["m"] * 3 + ["rad"] * 3))
    field.attrs["NOM"] = np.bytes_("".join(f"{part:<16}" for part in COMPONENTS))
    for i, shape in enumerate(package.shapes_B, 1):
        step = field.create_group(f"{i:020d}{1:020d}")
        hertz = float(package.frequencies[i - 1]) / (2.0 * np.pi)
        step.attrs.update({"NDT": i, "NOR": 1, "PDT": hertz, "RDT": -1, "ROR": -1})
        place = step.create_group("NOE")
        place.attrs.update({"GAU": BLANK, "PFL": np.bytes_(NO_PROFILE)})
        values = place.create_group(NO_PROFILE)
        values.attrs.update({"NBR": len(shape), "NGA": 1, "GAU": BLANK})
        values.create_dataset("CO", data=shape.ravel(order="F"))


def read(files: Files) -> ModalBody:
    """Body from `med` and `masses` (CSV: node, mass and inertias).

    Raises InputError for a file of another kind, without modes, or with values on a part only.
    """
    files.only(("med", "masses"), ("field",))
    path = files.path("med")
    name = str(files.table.get("field", FIELD))
    try:
        with h5py.File(path) as file:
            (mesh,) = (item[MESH_STEP] for item in file["ENS_MAA"].values())
            nodes = mesh["NOE/COO"][()].reshape(3, -1).T
            ids = mesh["NOE/NUM"][()] if "NUM" in mesh["NOE"] else np.arange(1, len(nodes) + 1)
            if name not in file["CHA"]:
                hint = nearest(name, file["CHA"])
                raise InputError(f"{path}: no field {name!r} of the modes{hint}")
            steps = list(file[f"CHA/{name}"].values())
            hertz = np.array([float(step.attrs["PDT"]) for step in steps])
            parts = [step[f"NOE/{NO_PROFILE}/CO"][()] for step in steps]
            listed = file[f"CHA/{name}"].attrs["NOM"].decode()
            cells = _read_cells(mesh["MAI"])
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            f"{path}: expected a MED file with one mesh and modes at all its nodes ({error})"
        ) from error
    sizes = {len(part) // len(nodes) for part in parts if len(part) % len(nodes) == 0}
    if len(sizes) != 1 or not sizes <= {3, 6}:
        raise InputError(f"{path}: field {name!r}: expected 3 or 6 components at every node")
    (size,) = sizes
    components = listed.split()
    if components and (len(components) != size or not set(components) <= set(COMPONENTS)):
        raise InputError(
            f"{path}: field {name!r} has {' '.join(components)}; expected 3 or 6 components of "
            f"{' '.join(COMPONENTS)} at every node"
        )
    columns = [COMPONENTS.index(part) for part in components] or range(size)
    shapes = np.zeros((len(parts), len(nodes), 6))
    for shape, part in zip(shapes, parts, strict=True):
        shape[:, columns] = part.reshape(size, -1).T
    order = np.argsort(hertz, kind="stable")
    ids = np.asarray(ids, dtype=np.int64)
    return ModalBody(files.where, nodes, ids, cells, shapes[order], hertz[order], size == 6)


def _read_cells(groups: h5py.Group) -> Cells:
    cells, types = [], []
    for kind, (title, order) in MED_CELLS.items():
        if title in groups:
            rows = groups[title]["NOD"][()].reshape(len(order), -1).T - 1
            back = np.argsort(order)
            cells += rows[:, back].tolist()
            types += [kind] * len(rows)
    return Cells.of(cells, types)
