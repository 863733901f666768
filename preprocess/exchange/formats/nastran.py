"""Bodies of the NASTRAN family: K and M in OUTPUT4 files, nodes and shells in bulk data.

Bulk data is read in small, large and free field format, with the laminates of PCOMP and PSHELL.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ....solver.package.specification import PlyTable
from ..free_body import DIRECTIONS, Cells, FreeBody, Layups, free_body, rows_of
from ..import_table import Files, fortran_number, text_lines

# Card -> number of nodes, from the third field on -> VTK type
ELEMENTS = {
    "CQUAD4": {4: 9},
    "CQUADR": {4: 9},
    "CTRIA3": {3: 5},
    "CTRIAR": {3: 5},
    "CTETRA": {4: 10, 10: 24},
    "CPENTA": {6: 13, 15: 26},
    "CHEXA": {8: 12, 20: 25},
    "CBAR": {2: 3},
    "CBEAM": {2: 3},
    "CROD": {2: 3},
}
# NASTRAN lists the nodes on vertical edges before those of the upper face, VTK after them.
ORDER = {25: [*range(12), *range(16, 20), *range(12, 16)], 26: [*range(9), 12, 13, 14, 9, 10, 11]}
Card = tuple[str, list[str]]  # name and fields
DOUBLE = {1: "f4", 2: "f8"}  # type of the matrix -> its numbers; complex ones are refused
HEADER = (24, 32)  # bytes: name of 8 characters, or two words of a 64-bit writer
BIG = 65536  # a sparse matrix of as many rows has BIGMAT, as one with its number of rows below 0
NAMES = {"stiffness": ("KGG", "KAA"), "mass": ("MGG", "MAA")}
NOTHING = 1e-12  # diagonal of a dof without stiffness and mass, relative to the largest
SHELLS = {"CQUAD4": 4, "CTRIA3": 3}  # number of corners; then come an angle and an offset
MOST_NU23 = 0.45  # where E2 / (2 G2Z) - 1 is no ratio of a material


def read_bulk_data(path: Path, cards: Sequence[Card]) -> tuple[IntArray, Array, Cells]:
    """Labels in ascending order (n,), coordinates (n, 3), cells.

    Parameters
    ----------
    path : of the deck, for messages
    cards : `bulk_cards` of it

    Raises InputError for nodes in a coordinate system of their own, and scalar points.
    """
    points: dict[int, list[float]] = {}
    cells: list[list[int]] = []
    types: list[int] = []
    for card, fields in cards:
        if card in ("GRID", "GRDSET") and any(
            fields[k] not in ("", "0") for k in (1, 5) if k < len(fields)
        ):
            raise InputError(
                f"{path}: {f'{card} {fields[0]}'.rstrip()} has a coordinate system of its own "
                "(CP or CD); expected the basic one"
            )
        if card == "GRID":
            label = int(fields[0])
            values = [*fields[2:5], "", "", ""][:3]
            points[label] = [real(text, path, card) for text in values]
        elif card == "SPOINT":
            raise InputError(f"{path}: SPOINT: expected grid points only")
        elif card in ELEMENTS:
            kinds = ELEMENTS[card]
            listed = fields[2 : 2 + max(kinds)]
            nodes = [int(text) for text in listed if text.isdecimal() and int(text) > 0]
            size = max((k for k in kinds if k <= len(nodes)), default=0)
            if not size:
                raise InputError(f"{path}: {card} {fields[0]}: expected {min(kinds)} nodes")
            kind = kinds[size]
            order = ORDER.get(kind, range(size))
            cells.append([nodes[k] for k in order])
            types.append(kind)
    if not points:
        raise InputError(f"{path}: no GRID; expected bulk data")
    ids = np.array(sorted(points), dtype=np.int64)
    rows = [rows_of(np.array(cell), ids, str(path)).tolist() for cell in cells]
    return ids, np.array([points[int(i)] for i in ids]), Cells.of(rows, types)


def bulk_cards(path: Path) -> Iterator[Card]:
    """Name and fields of each card; continuation lines are joined.

    Raises InputError for INCLUDE, for replication, and for more than ten fields in a line.
    """
    lines = [line.split("$")[0].rstrip() for line in text_lines(path)]
    begin = [i for i, line in enumerate(lines) if line.upper().startswith("BEGIN")]
    card, fields = "", list[str]()
    for line in lines[begin[0] + 1 if begin else 0 :]:
        if not line.strip():
            continue
        name, more = _fields(line.expandtabs())
        if name[:1] == "=" or name.startswith("INCLUDE") or "".join(line.split(",")[10:]).strip():
            raise InputError(
                f"{path}: {line[:60]!r}: expected whole cards of at most ten fields a line, all in "
                "this file, without INCLUDE and replication (=)"
            )
        if name == "" or name[0] in "+*":
            fields += more
            continue
        if card:
            yield card, fields
        card, fields = name, more
        if card == "ENDDATA":
            return
    if card:
        yield card, fields


def _fields(line: str) -> tuple[str, list[str]]:
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        name, count = words[0], 4 if "*" in words[0] else 8
        data = [*words[1:], *[""] * count][:count]
    else:
        width, count = (16, 4) if "*" in line[:8] else (8, 8)
        data = [line[8 + width * k : 8 + width * (k + 1)].strip() for k in range(count)]
        name = line[:8].strip()
    name = name.upper()
    return name.rstrip("*") if name[:1] != "*" else name, data


def real(text: str, path: Path, card: str) -> float:
    """A number of NASTRAN: the E of an exponent may be missing.

    Parameters
    ----------
    text : field of a card; empty: 0
    path, card : for messages

    Raises
    ------
    InputError
        Text that is no number.
    """
    if not text:
        return 0.0
    try:
        return fortran_number(text)
    except ValueError as error:
        raise InputError(f"{path}: {card}: expected a number, found {text!r}") from error


def read_op4(path: Path) -> dict[str, sp.csr_matrix]:
    """Matrices by name. A form "symmetric" still holds both triangles, or only one: see `K`, `M`.

    Raises InputError for a file that ends early or holds complex matrices.
    """
    data = path.read_bytes()
    order = "<" if data[:4] != b"" and int.from_bytes(data[:4], "little") in HEADER else ">"
    matrices: dict[str, sp.csr_matrix] = {}
    records = _records(data, order, path)
    for record in records:
        columns, rows, _, kind = np.frombuffer(record[:16], f"{order}i4").tolist()
        name = record[16:24].decode("ascii", "replace").strip()
        if kind not in DOUBLE:
            raise InputError(f"{path}: matrix {name} has the type {kind}: expected a real one")
        # every row of a body has a number
        if not 0 < columns <= len(data) or abs(rows) > len(data):
            raise InputError(
                f"{path}: matrix {name}: {abs(rows)} x {columns} in a file of {len(data)} bytes: "
                "expected a matrix with at least one number in each row"
            )
        number = np.dtype(f"{order}{DOUBLE[kind]}")
        entries = [(np.zeros(0, int), np.zeros(0, int), np.zeros(0))]
        for column in records:
            at, first, _ = np.frombuffer(column[:12], f"{order}i4").tolist()
            if at > columns:
                break
            for row, values in _strings(column[12:], first, number, order, not 0 < rows < BIG):
                used = np.flatnonzero(values)
                entries.append((row - 1 + used, np.full(len(used), at - 1), values[used]))
        else:
            raise InputError(f"{path}: matrix {name}: the file ends before its last column")
        at_rows, at_columns, value = (np.concatenate(part) for part in zip(*entries, strict=True))
        matrices[name] = sp.csr_matrix((value, (at_rows, at_columns)), (abs(rows), columns))
    if not matrices:
        raise InputError(f"{path}: no matrix; expected a binary OUTPUT4 file")
    return matrices


def _records(data: bytes, order: str, path: Path) -> Iterator[bytes]:
    """Records of a Fortran file: length, bytes, length."""
    place = 0
    while place < len(data):
        size = int(np.frombuffer(data[place : place + 4], f"{order}i4")[0])
        end = place + 4 + size
        if size < 0 or data[end : end + 4] != data[place : place + 4]:
            raise InputError(
                f"{path}: damaged at byte {place}; expected a binary OUTPUT4 file, no text"
            )
        yield data[place + 4 : end]
        place = end + 4


def _strings(
    data: bytes, first: int, number: np.dtype, order: str, big: bool
) -> Iterator[tuple[int, np.ndarray]]:
    """First row and values of each string of a column.

    A dense column is one string. A sparse one (first = 0) has a word before each: its length in
    words plus one, times 65536, plus its first row. These are two words in a `big` matrix.
    """
    if first > 0:
        yield first, np.frombuffer(data[: len(data) // number.itemsize * number.itemsize], number)
        return
    place, head = 0, 8 if big else 4
    while place + head <= len(data):
        words = np.frombuffer(data[place : place + head], f"{order}i4").tolist()
        size, row = words if big else divmod(words[0], BIG)
        if size <= 1:
            return
        place, end = place + head, place + head + 4 * (size - 1)
        yield row, np.frombuffer(data[place:end], number)
        place = end


def read(files: Files) -> FreeBody:
    """Body from `bulk` (deck) and `matrices` (OUTPUT4 with KGG and MGG), or two files.

    The rows are those of all grid points in ascending order, six each. Dofs without stiffness and
    mass (drilling of flat shells, rotations of solids) are left out.

    Raises InputError for matrices of another size or other names.
    """
    files.only(("bulk",), ("matrices", "stiffness", "mass"))
    deck = files.path("bulk")
    cards = list(bulk_cards(deck))
    ids, nodes, cells = read_bulk_data(deck, cards)
    K, M = (_matrix(files, key) for key in ("stiffness", "mass"))
    for name, A in (("stiffness", K), ("mass", M)):
        if A.shape != (6 * len(ids), 6 * len(ids)):
            raise InputError(
                f"{files.where}: {name}: {A.shape[0]} x {A.shape[1]}, but {len(ids)} grid points "
                f"have {6 * len(ids)} degrees of freedom; expected KGG and MGG, which no support "
                "reduces"
            )
    dofs = np.column_stack([np.repeat(ids, 6), np.tile(np.arange(1, 7), len(ids))])
    kept = _used(K) | _used(M)
    dropped = np.flatnonzero(~kept)
    counts = {
        name: int(np.count_nonzero(dropped % 6 == k))
        for k, name in enumerate(DIRECTIONS)
        if np.count_nonzero(dropped % 6 == k)
    }
    notes = {**files.notes(), "degrees of freedom without stiffness and mass": counts}
    layups: Layups | str | None = read_layups(deck, cards, nodes, cells)
    if isinstance(layups, str):
        notes["ply stresses"] = f"none: {layups}"
        layups = None
    K, M = (A[kept][:, kept] for A in (K, M))
    return free_body(files.where, K, M, nodes, ids, dofs[kept], cells, notes=notes, layups=layups)


def _used(A: sp.csr_matrix) -> IntArray:
    largest = np.asarray(abs(A).max(axis=1).todense()).ravel()
    return np.asarray(largest > NOTHING * largest.max())


def _matrix(files: Files, key: str) -> sp.csr_matrix:
    path = files.path(key if key in files else "matrices")
    matrices = read_op4(path)
    for name in NAMES[key]:
        if name in matrices:
            A = matrices[name]
            one_triangle = not (sp.triu(A, 1).nnz and sp.tril(A, -1).nnz)
            # MYSTRAN writes form 1 and both triangles; others one triangle of form 6.
            return sp.csr_matrix(A + A.T - sp.diags(A.diagonal())) if one_triangle else A
    raise InputError(
        f"{path}: matrices {', '.join(matrices)}; expected {' or '.join(NAMES[key])} for {key}"
    )


class NotRead(Exception):
    """A deck has shells whose plies are not understood; the words say which."""


def read_layups(path: Path, deck: Sequence[Card], nodes: Array, cells: Cells) -> Layups | str:
    """Return the laminates of all shells of a deck; or why there are none.

    Parameters
    ----------
    path : of the deck, for messages
    deck : `bulk_cards` of it
    nodes, cells : as `read_bulk_data` returns them
    """
    cards = [(name, [*fields, *[""] * 20]) for name, fields in deck]
    listed = [(name, fields) for name, fields in cards if name in ELEMENTS]
    by_id = {
        (name, fields[0]): fields
        for name, fields in cards
        if name in ("PCOMP", "PSHELL", "MAT8", "MAT1")
    }
    materials: dict[str, dict[str, object]] = {}
    laminates: dict[str, dict[str, object]] = {}
    rows, numbers, axes = [], [], []
    try:
        for cell, (name, fields) in enumerate(listed):
            if name not in SHELLS:
                continue
            label = f"laminate {fields[1]}"
            if label not in laminates:
                laminates[label] = _laminate(by_id, fields[1], materials, path)
            start = int(cells.offsets[cell])
            corners = nodes[cells.connectivity[start : start + SHELLS[name]]]
            axes.append(_axes(corners, name, fields, path))
            rows.append(cell)
            numbers.append(list(laminates).index(label))
    except NotRead as error:
        return str(error)
    if not rows:
        return "no shells"
    return Layups(materials, laminates, np.array(rows), np.array(numbers), np.array(axes))


def _laminate(
    by_id: dict[tuple[str, str], list[str]],
    number: str,
    materials: dict[str, dict[str, object]],
    path: Path,
) -> dict[str, Any]:
    """Table of plies of a property; its materials are added to `materials`."""
    if ("PCOMP", number) in by_id:
        fields = by_id["PCOMP", number]
        plies = _plies(fields[8:], path)
        if fields[7].upper() == "SYM":
            plies += [ply.copy() for ply in plies[::-1]]
        elif fields[7]:
            raise NotRead(f"PCOMP {number}: LAM = {fields[7]}")
        total = sum(float(ply["thickness"]) for ply in plies)
        bottom = real(fields[1], path, "PCOMP") if fields[1] else -0.5 * total
        offset = bottom + 0.5 * total
    elif ("PSHELL", number) in by_id:
        fields = by_id["PSHELL", number]
        if fields[3] != fields[1] or fields[4] not in ("", "1.", "1.0"):
            raise NotRead(f"PSHELL {number}: expected MID2 = MID1, and 12I/T3 of a plate")
        thickness = real(fields[2], path, "PSHELL")
        plies = [{"material": fields[1], "angle_deg": 0.0, "thickness": thickness}]
        offset = 0.0
    else:
        raise NotRead(f"property {number} is no PCOMP or PSHELL")
    for ply in plies:
        name = f"MAT {ply['material']}"
        materials.setdefault(name, _material(by_id, str(ply["material"]), path))
        ply["material"] = name
    return {"plies": plies, "offset": offset}


def _plies(fields: list[str], path: Path) -> list[PlyTable]:
    """Four fields a ply: material, thickness (both as before if blank), angle, output."""
    plies: list[PlyTable] = []
    material, thickness = "", 0.0
    for at in range(0, len(fields) - 3, 4):
        if not any(fields[at : at + 3]):
            continue
        material = fields[at] or material
        thickness = real(fields[at + 1], path, "PCOMP") if fields[at + 1] else thickness
        angle = real(fields[at + 2], path, "PCOMP")
        plies.append({"material": material, "angle_deg": angle, "thickness": thickness})
    return plies


def _material(by_id: dict[tuple[str, str], list[str]], number: str, path: Path) -> dict[str, Any]:
    """Constants of MAT8 or MAT1.

    MAT8 has no constants across the ply: E3 = E2, nu13 = nu12 and, with G23 = G2Z, nu23 as of a
    material that is isotropic in 2 and 3. G1Z and G2Z that are blank count as G12.
    """
    if ("MAT1", number) in by_id:
        E, G, nu, rho = (real(text, path, "MAT1") for text in by_id["MAT1", number][1:5])
        if not nu and G:
            nu = E / (2.0 * G) - 1.0
        E = E or 2.0 * G * (1.0 + nu)
        return {"kind": "isotropic", "E": E, "nu": nu, "rho": rho}
    if ("MAT8", number) not in by_id:
        raise NotRead(f"material {number} is no MAT8 or MAT1")
    fields = by_id["MAT8", number]
    E1, E2, nu12, G12, G1Z, G2Z, rho = (real(text, path, "MAT8") for text in fields[1:8])
    G23 = G2Z or G12
    nu23 = E2 / (2.0 * G23) - 1.0
    table: dict[str, Any] = {"kind": "orthotropic", "E1": E1, "E2": E2, "E3": E2, "rho": rho}
    table |= {"G12": G12, "G13": G1Z or G12, "G23": G23, "nu12": nu12, "nu13": nu12}
    table["nu23"] = float(np.clip(nu23, 0.0, MOST_NU23))
    strengths = [real(text, path, "MAT8") for text in fields[11:16]]
    if all(strengths) and fields[18] not in ("1", "1.", "1.0"):  # STRN: allowed strains
        table["strength"] = dict(zip(("Xt", "Xc", "Yt", "Yc", "S12"), strengths, strict=True))
    return table


def _axes(corners: Array, name: str, fields: list[str], path: Path) -> Array:
    """Axes of the laminate of an element, (3, 3): angles count from the side of nodes 1 and 2."""
    count = SHELLS[name]
    theta, offset = fields[2 + count], fields[3 + count]
    label = f"{name} {fields[0]}"
    if offset and real(offset, path, name):
        raise NotRead(f"{label}: ZOFFS")
    if any(fields[10:14]):
        raise NotRead(f"{label}: thicknesses of its own")
    e3 = np.cross(corners[2] - corners[0], corners[-1] - corners[1])  # also of triangles
    e3 /= np.linalg.norm(e3)
    along = corners[1] - corners[0]
    angle = 0.0
    if theta and ("." in theta or "E" in theta.upper()):
        angle = np.deg2rad(real(theta, path, name))
    elif theta == "0":  # MCID: x of the basic system
        along = np.array([1.0, 0.0, 0.0])
    elif theta:
        raise NotRead(f"{label}: MCID = {theta}: a coordinate system of its own")
    e1 = along - (along @ e3) * e3
    e1 /= np.linalg.norm(e1)
    e1 = np.cos(angle) * e1 + np.sin(angle) * np.cross(e3, e1)
    return np.column_stack([e1, np.cross(e3, e1), e3])
