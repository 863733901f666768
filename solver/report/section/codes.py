"""A section's matrices in the order, signs and axes of other codes, and at other points.

In all these codes forces, moments, strains and curvatures are vectors, right-handed about the axes
of the section. They differ in the axis along the beam. A conversion is therefore a rotation; for
the blade axes of BeamDyn it may also reverse the direction of the beam. docs/conventions.md shows
the axes and the sources. Input files of VABS, BECAS, BeamDyn and HAWC2 are written in these
conventions.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, PackageError, did_you_mean, printable
from ...inputs.section.vabs import OF_VABS
from ...math.arrays import Array, IntArray
from ...package.common.container import contents, open_file
from ...package.common.files import write_text
from ...package.common.findings import raise_first
from ...package.common.materials import elastic_from_dict
from ...package.common.object_file import check_provenance, checksum_findings, identity_notes
from ...package.common.recovery_schema import CORNERS
from ...package.section.codes import AXES, CODES, OF_BLADES, OF_MESHES
from ...package.section.section_file import SECTION_FILE, read_section
from ...package.section.section_schema import SectionFile, SectionProperties

# Blade axes of BeamDyn (x to the suction side, y to the trailing edge, z from root to tip) for
# sections whose x3 points to the suction side. With x2 to the trailing edge, as in airfoil
# coordinates, x1 points from tip to root.
Axes = Sequence[Sequence[float]] | Array
BLADE_AXES_TRAILING_EDGE: Axes = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
BLADE_AXES_LEADING_EDGE: Axes = ((0, 0, 1), (0, -1, 0), (1, 0, 0))

_SHAPES = {
    "stiffness": (6, 6),
    "mass": (6, 6),
    "compliance": (6, 6),
    "resultants": (6,),
    "strains": (6,),
}
KINDS = tuple(_SHAPES)


def convert(
    value: Array,
    to: str,
    kind: str = "stiffness",
    *,
    source: str = "plymotion",
    blade_axes: Axes = BLADE_AXES_TRAILING_EDGE,
) -> Array:
    """Return a matrix or vector of a section in the convention of another code.

    Parameters
    ----------
    value : (6, 6) stiffness, mass or compliance, or (6,) resultants or strains, of `source`
    to, source : one of CODES
    kind : one of KINDS
    blade_axes : (3, 3) rotation for BeamDyn: its local axes x, y, z as rows of components in
        x1, x2, x3; z is x1 or -x1. By default x2 points to the trailing edge and x3 to the
        suction side.

    The reference point does not change; BeamDyn needs it on its reference axis: see `transform`.

    Raises
    ------
    InputError : unknown code or kind, wrong shape, axes that are not a rotation.
    """
    old, new = _axes_of(source, blade_axes), _axes_of(to, blade_axes)
    A = new @ old.T  # v_to = A v_source
    # If the direction of the beam is reversed, its strains and the forces on the section's face
    # change sign.
    direction = _direction(old) * _direction(new)
    return _changed(_checked(value, kind), direction * _both(A).T, kind)


def transform(
    value: Array,
    translation: Array | tuple[float, float] = (0.0, 0.0),
    rotation: float = 0.0,
    kind: str = "stiffness",
) -> Array:
    """Return a matrix or vector of a section about another reference point and in rotated axes.

    Parameters
    ----------
    value : as in `convert`, in our order
    translation : (2,) x2 and x3 of the new reference point, in the old axes [m]
    rotation : angle of the new axes, from x2 towards x3 [rad]; the point moves first
    kind : one of KINDS

    Raises
    ------
    InputError : unknown kind, wrong shape.
    """
    value = _checked(value, kind)
    shift = np.asarray(translation, dtype=float)
    if shift.shape != (2,) or not np.isfinite(shift).all():
        raise InputError(f"translation = {translation!r}: expected x2 and x3 [m]")
    y, z = shift
    # Strains at the old point follow from those at the new one and the arm r = (0, y, z) between
    # them: gamma_old = gamma_new + r x kappa.
    move = np.eye(6)
    move[:3, 3:] = [[0.0, -z, y], [z, 0.0, 0.0], [-y, 0.0, 0.0]]
    c, s = np.cos(rotation), np.sin(rotation)
    turn = _both(np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]))
    return _changed(value, move @ turn.T, kind)


def _changed(value: Array, T: Array, kind: str) -> Array:
    """Value for new strains, with old strains = T times new strains and equal work."""
    if kind == "resultants":
        return np.asarray(T.T @ value)
    if kind == "strains":
        return np.asarray(np.linalg.solve(T, value))
    if kind == "compliance":
        inverse = np.linalg.inv(T)
        return np.asarray(inverse @ value @ inverse.T)
    return np.asarray(T.T @ value @ T)


def _both(A: Array) -> Array:
    """Rotation of forces and moments, (6, 6)."""
    return np.asarray(np.kron(np.eye(2), A), dtype=np.float64)


def _direction(axes: Array) -> float:
    """Return -1 if the beam axis is -x1, otherwise 1."""
    return -1.0 if axes[:, 0].sum() < 0.0 else 1.0


def _axes_of(code: str, blade_axes: Axes) -> Array:
    if code != "beamdyn":
        if code not in AXES:
            raise InputError(
                f"code = {code!r}: expected one of {', '.join(CODES)}" + did_you_mean(code, CODES)
            )
        return np.array(AXES[code], dtype=float)
    axes = np.asarray(blade_axes, dtype=float)
    good = axes.shape == (3, 3) and np.allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-9)
    if not good or np.linalg.det(axes) < 0.0:
        raise InputError("blade_axes: expected a rotation (3, 3), orthonormal and right-handed")
    if abs(abs(axes[2, 0]) - 1.0) > 1e-9:
        raise InputError("blade_axes: expected a third row of 1 or -1, 0, 0: z along the beam")
    return axes


def _checked(value: Array, kind: str) -> Array:
    if kind not in _SHAPES:
        raise InputError(
            f"kind = {kind!r}: expected one of {', '.join(KINDS)}" + did_you_mean(kind, KINDS)
        )
    value = np.asarray(value, dtype=float)
    if value.shape != _SHAPES[kind]:
        raise InputError(f"{kind}: expected shape {_SHAPES[kind]}, got {value.shape}")
    return value


@dataclass(frozen=True, kw_only=True)
class SectionResults(SectionProperties):
    """The numbers of a section; lengths in m, forces in N."""

    @property
    def dofs(self) -> int:
        """Unknowns of the analysis."""
        return int(self.provenance.get("dofs", 0))

    @property
    def seconds(self) -> float:
        """Time of the analysis."""
        return float(self.provenance.get("seconds", 0.0))

    @property
    def refinements(self) -> list[dict[str, float]]:
        """Each with refine, dofs, error, seconds."""
        return list(self.provenance.get("refinements", []))

    @property
    def verification(self) -> str | None:
        """Outcome of `--verify`."""
        return self.provenance.get("verification")

    @property
    def scaled_error(self) -> Array | None:
        """The estimate in units of sqrt(K_ii K_jj), (6, 6) [-]."""
        if self.error_estimate is None:
            return None
        size = np.sqrt(np.diag(self.K))
        return np.asarray(self.error_estimate / np.outer(size, size))

    @property
    def worst_error(self) -> float | None:
        """Largest entry of `scaled_error`."""
        return None if self.scaled_error is None else float(np.max(self.scaled_error))


def read_results(file: Path) -> SectionResults:
    """Read the numbers of a section file. Raises PackageError for another or a damaged file."""
    with open_file(file, PackageError) as hdf:
        identity_notes(file, hdf, SECTION_FILE)
        items = contents(hdf[SECTION_FILE.group])
        findings = SECTION_FILE.layout_findings(items) + checksum_findings(hdf, SECTION_FILE)
        raise_first(file, findings)
        results = SECTION_FILE.load(items, SectionResults)
    check_provenance(file, results.provenance)
    return results


# Text files that appear only when they are complete.


def written(file: Path, lines: Iterable[str]) -> Path:
    """Write lines to a file; returns the file."""
    write_text(file, "\n".join(lines) + "\n")
    return file


# Mesh, materials and orientations of a section as input of VABS and of BECAS.
#
# Each cell has one ply and one layer direction, those of its middle; `turning_cells` counts cells
# in which the direction turns more.

KEYS = ("E1", "E2", "E3", "G12", "G13", "G23", "nu12", "nu13", "nu23")
TO_VABS = np.argsort(OF_VABS)
BECAS_FILES = ("N2D.in", "E2D.in", "EMAT.in", "MATPROPS.in")


def write_vabs(section: SectionFile, file: Path) -> Path:
    """Write a VABS input file (format 1) for the 6x6 stiffness; returns the file.

    Raises
    ------
    InputError
        A material without elastic constants.
    """
    mesh, recovery = section.mesh, section.recovery
    names = list(recovery.materials)
    curved = section.initial_curvature is not None
    lines = [f"1 {len(recovery.plies)}", "1 0 0", f"{int(curved)} 0 0 0"]
    if section.initial_curvature is not None:
        lines.append(_row(section.initial_curvature))
    lines.append(f"{len(mesh.nodes)} {len(mesh.cell_types)} {len(names)}")
    lines += [f"{i} {_row(x)}" for i, x in enumerate(mesh.nodes, start=1)]
    lines += [f"{i} {_nine(nodes, kind)}" for i, (nodes, kind) in _cells(section)]
    angles = np.degrees(np.arctan2(*mesh.layer_direction.T[::-1]))
    lines += [
        f"{i} {ply + 1} {angle:.17g}"
        for i, (ply, angle) in enumerate(zip(mesh.ply, angles, strict=True), start=1)
    ]
    lines += [
        f"{i} {names.index(ply.material) + 1} {ply.angle_deg:.17g}"
        for i, ply in enumerate(recovery.plies, start=1)
    ]
    for i, name in enumerate(names, start=1):
        table = recovery.materials[name]
        if table.get("kind") == "anisotropic":
            material = elastic_from_dict(table, f"materials.{name}", massless=True)
            C = material.stiffness_M[np.ix_(TO_VABS, TO_VABS)]
            lines += [f"{i} 2", *(_row(C[j, j:]) for j in range(6)), f"{table['rho']:.17g}"]
            continue
        constants, rho = _constants(name, table)
        lines += [f"{i} 1", *(_row(constants[j : j + 3]) for j in (0, 3, 6)), f"{rho:.17g}"]
    return written(file, lines)


def write_becas(section: SectionFile, folder: Path) -> Path:
    """Write the input files of BECAS into a folder; returns the folder.

    Nine-node cells lose the node in their centre: BECAS has quadrilaterals of 4 and 8 nodes.

    Raises
    ------
    InputError
        Triangles, which BECAS does not read in this form; a material without elastic constants.
    """
    mesh, recovery = section.mesh, section.recovery
    names = list(recovery.materials)
    rows = []
    for i, (nodes, kind) in _cells(section):
        if CORNERS[kind] == 3:
            raise InputError(f"section {section.name}: expected quadrilaterals only, for BECAS")
        nodes = nodes[:8]
        rows.append([i, *(n + 1 for n in nodes), *[0] * (8 - len(nodes))])
    used = sorted({n for row in rows for n in row[1:] if n})
    angles = np.degrees(np.arctan2(*mesh.layer_direction.T[::-1]))
    tables = (
        [f"{n} {_row(mesh.nodes[n - 1])}" for n in used],
        [" ".join(map(str, row)) for row in rows],
        [
            f"{i} {names.index(recovery.plies[ply].material) + 1} "
            f"{recovery.plies[ply].angle_deg:.17g} {angle:.17g}"
            for i, (ply, angle) in enumerate(zip(mesh.ply, angles, strict=True), start=1)
        ],
        [
            _row([*constants, rho])
            for constants, rho in (_constants(n, recovery.materials[n]) for n in names)
        ],
    )
    folder.mkdir(parents=True, exist_ok=True)
    for name, lines in zip(BECAS_FILES, tables, strict=True):
        written(folder / name, lines)
    return folder


def turning_cells(section: SectionFile) -> int:
    """Number of cells whose ply or layer direction is not that of their middle everywhere."""
    recovery = section.recovery
    fibre = recovery.A_BM[:, :, 0]
    other = np.abs(fibre - section.mesh.fibre[recovery.cell]).max(axis=1) > 1e-9
    other |= recovery.ply != section.mesh.ply[recovery.cell]
    return int(np.unique(recovery.cell[other]).size)


def _cells(section: SectionFile) -> Iterable[tuple[int, tuple[IntArray, int]]]:
    """Number from 1, nodes and VTK type of every cell."""
    mesh = section.mesh
    parts = np.split(mesh.connectivity, mesh.offsets[1:-1])
    pairs = zip(parts, map(int, mesh.cell_types), strict=True)
    return enumerate(pairs, start=1)


def _nine(nodes: IntArray, kind: int) -> str:
    """Nodes from 1 in nine places; the fourth of a triangle is 0."""
    numbers = [int(n) + 1 for n in nodes]
    if CORNERS[kind] == 3:
        numbers = [*numbers[:3], 0, *numbers[3:]]
    return " ".join(map(str, [*numbers, *[0] * (9 - len(numbers))]))


def _constants(name: str, table: Mapping[str, Any]) -> tuple[list[float], float]:
    """Nine constants and the density of a material."""
    if table.get("kind") == "isotropic":
        E, nu = float(table["E"]), float(table["nu"])
        return [E] * 3 + [E / (2.0 * (1.0 + nu))] * 3 + [nu] * 3, float(table["rho"])
    if not all(key in table for key in KEYS):
        raise InputError(f"materials.{name}: expected nine elastic constants in the section file")
    return [float(table[key]) for key in KEYS], float(table["rho"])


def _row(values: Iterable[float] | Array) -> str:
    return " ".join(f"{float(value):.17g}" for value in values)


# Blade files from the 6x6 of stations: BeamDyn's blade file and HAWC2's st file.

UPPER = np.triu_indices(6)


def write_beamdyn(
    file: Path,
    places: Sequence[float],
    stiffness: Sequence[Array],
    mass: Sequence[Array],
    *,
    title: str,
    damping: Sequence[float] = (0.0,) * 6,
    blade_axes: Axes = BLADE_AXES_TRAILING_EDGE,
) -> Path:
    """Write a blade file of BeamDyn in the format of OpenFAST 5; returns the file.

    Parameters
    ----------
    places : positions of the stations along the blade, ascending; they are divided by the last one
    stiffness, mass : (6, 6) of each station in our order, about BeamDyn's reference axis
    damping : stiffness-proportional coefficients mu of the six directions [s]
    blade_axes : see `convert`

    Raises
    ------
    InputError
        Fewer than two stations, positions that do not ascend, other numbers of matrices.
    """
    x = _stations(places, stiffness, mass)
    eta = (x - x[0]) / (x[-1] - x[0])
    lines = [
        " ------- BEAMDYN INDIVIDUAL BLADE INPUT FILE --------------------------",
        f" {printable(title)}",
        " ---------------------- BLADE PARAMETERS --------------------------------------",
        f"{len(x):6d}   station_total    - Number of blade input stations (-)",
        f"{int(any(damping)):6d}   damp_type        - 0: no damping; 1: by stiffness; 2: modal",
        " ---------------------- DAMPING COEFFICIENT------------------------------------",
        "   mu1        mu2        mu3        mu4        mu5        mu6",
        "   (-)        (-)        (-)        (-)        (-)        (-)",
        " " + " ".join(f"{value:.6E}" for value in damping),
        " ---------------------- MODAL DAMPING -----------------------------------------",
        "     0   n_modes          - Number of modal damping coefficients (-)",
        "   0.0   zeta             - Modal damping coefficients",
        " ---------------------- DISTRIBUTED PROPERTIES---------------------------------",
    ]
    for place, K, M in zip(eta, stiffness, mass, strict=True):
        lines.append(f"  {place:.12f}")
        for matrix, kind in ((K, "stiffness"), (M, "mass")):
            for row in convert(matrix, "beamdyn", kind, blade_axes=blade_axes):
                lines.append("  " + "  ".join(f"{value: .15E}" for value in row))
            lines.append("")
    return written(file, lines)


def write_hawc2(
    file: Path,
    places: Sequence[float],
    stiffness: Sequence[Array],
    mass: Sequence[Array],
    *,
    title: str,
) -> Path:
    """Write an st file of HAWC2 with fully populated stiffness (FPM); returns the file.

    Each row has r, m, x_cg, y_cg, ri_x, ri_y, pitch, x_e, y_e and the upper triangle of the
    stiffness about the elastic centre in the order of BECAS (shear x, shear y, axial, bending x,
    bending y, torsion). x and y are x2 and x3, z is x1; pitch is 0. The radii of gyration are about
    the elastic centre; the format has no product of inertia.

    Parameters
    ----------
    places : arc length of the stations along the half-chord line, ascending [m]
    stiffness, mass : (6, 6) of each station in our order, about the half-chord line
    """
    x = _stations(places, stiffness, mass)
    names = ["r", "m", "x_cg", "y_cg", "ri_x", "ri_y", "pitch", "x_e", "y_e"]
    names += [f"K_{i + 1}{j + 1}" for i, j in zip(*UPPER, strict=True)]
    rows = []
    for r, K, M in zip(x - x[0], stiffness, mass, strict=True):
        # (x2, x3) where an axial force does not bend the beam [m].
        S = np.linalg.inv(K)
        M2, M3 = np.linalg.solve(S[4:, 4:], -S[4:, 0])
        centre = np.array([-M3, M2])
        m = M[0, 0]
        at_centre = transform(M, centre, kind="mass")
        radii = np.sqrt(np.diag(at_centre)[4:] / m)
        moved = convert(transform(K, centre), "becas")
        values = [r, m, -M[0, 5] / m, M[0, 4] / m, *radii, 0.0, *centre, *moved[UPPER]]
        rows.append(" ".join(f"{value: .15e}" for value in values))
    lines = [
        "1 number of sets, Nset",
        f"#1 {printable(title)}",
        " ".join(f"{n:>22s}" for n in names),
    ]
    return written(file, [*lines, f"$1 {len(rows)}", *rows])


def _stations(places: Sequence[float], stiffness: Sequence[Array], mass: Sequence[Array]) -> Array:
    x = np.asarray(places, dtype=float)
    if len(x) < 2 or not np.all(np.diff(x) > 0.0):
        raise InputError("stations: expected two positions or more, ascending")
    if not len(x) == len(stiffness) == len(mass):
        raise InputError(f"stations: expected {len(x)} sections, one for each position")
    return x


# Which files of other codes a command writes.


def write_for(
    code: str, files: Sequence[Path], stations: Sequence[float] | None, folder: Path
) -> list[str]:
    """Write the input of another code from section files; returns lines about what was written.

    Parameters
    ----------
    code : one of TARGETS
    files : section files, those of a blade in the order of its stations
    stations : their positions along the blade [m], for OF_BLADES
    folder : where the file of a blade is written

    Raises
    ------
    InputError
        Stations that are missing or do not match the sections.
    """
    if code in OF_MESHES:
        if stations:
            raise InputError(f"--stations: expected with --to {' or '.join(OF_BLADES)} only")
        return [line for file in files for line in _mesh(code, file)]
    if stations is None or len(stations) != len(files):
        given = 0 if stations is None else len(stations)
        raise InputError(
            f"--to {code}: expected --stations with a position for each of the {len(files)} "
            f"sections, found {given}"
        )
    results = [read_results(file) for file in files]
    matrices = [r.K for r in results], [r.M for r in results]
    title = f"{len(files)} stations, {results[0].name} to {results[-1].name}"
    if code == "beamdyn":
        return [str(write_beamdyn(folder / "blade_beamdyn.dat", stations, *matrices, title=title))]
    return [str(write_hawc2(folder / "blade_hawc2_st.dat", stations, *matrices, title=title))]


def _mesh(code: str, file: Path) -> list[str]:
    section = read_section(file)
    target = file.with_suffix(".dat") if code == "vabs" else file.parent / "becas"
    made = write_vabs(section, target) if code == "vabs" else write_becas(section, target)
    turning = turning_cells(section)
    if not turning:
        return [str(made)]
    return [
        str(made),
        f"{made}: in {turning} cells the layer direction or the ply changes; the file has that of "
        "their middle",
    ]
