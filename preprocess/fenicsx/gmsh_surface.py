"""Surface meshes by gmsh: scripts with parameters, and mesh files, as plain arrays."""

import inspect
import re
import signal
import tempfile
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np

from ...solver.errors import few
from ..mesh_input import SUFFIXES, is_ours, is_refused, load_script
from .gmsh_alone import GmshEndedError, Parameters, allow, apart, cell_count, generate
from .libraries import Array, MeshError, gmsh
from .plain_mesh import IntArray, NamedNodes, PlainMesh, with_centre_nodes

CELLS = {
    2: ("triangle", 1, 3),
    3: ("quadrilateral", 1, 4),
    9: ("triangle", 2, 6),
    10: ("quadrilateral", 2, 9),
    16: ("quadrilateral", 2, 8),  # serendipity
}
SURFACE = ("mixed", 1, 4)  # triangles have -1 as fourth node
LINES = {1: 2, 8: 3}


def plain_from_model(where: str, gdim: int = 2) -> PlainMesh:
    """Read the surfaces of the current gmsh model, each in one physical group, and named curves.

    Raises
    ------
    MeshError : solid cells, cells of a degree above 2, surfaces in no or in two physical groups,
        groups without cells; if gdim is 2, nodes outside the plane z = 0. Triangles and
        quadrilaterals of degree 1 may be mixed: see `SURFACE`.
    """
    _check_kinds(where)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    tags, every = np.asarray(tags, dtype=np.int64)[order], np.reshape(coordinates, (-1, 3))[order]
    groups = _surface_groups(where)
    _check_membership(groups, where)
    kinds = sorted(int(kind) for kind in gmsh.model.mesh.getElementTypes(2))
    shape, degree, n_node = CELLS[kinds[0]] if len(kinds) == 1 else SURFACE
    parts, rows = [], []
    for row, (name, entities) in enumerate(groups.items()):
        tables = [_cells(kind, entities, n_node) for kind in kinds]
        if not any(len(nodes) for nodes in tables):
            raise MeshError(f"{where}: physical surface {name!r} has no cells")
        parts += tables
        rows.append(np.full(sum(map(len, tables)), row))
    labels = np.concatenate(parts)
    used = np.searchsorted(tags, np.unique(labels[labels >= 0]))
    position = np.full(len(tags), -1)
    position[used] = np.arange(len(used))
    at = position[np.searchsorted(tags, np.maximum(labels, tags[0]))]
    cells = np.where(labels < 0, -1, at)
    check_mesh(every[used], tags[used], cells, where)
    points = _in_plane(every[used], where) if gdim == 2 else every[used]
    if n_node == 8:
        points, cells = with_centre_nodes(points, cells)
    named_curves = curves(tags, every, gdim)
    named = _named_nodes(tags, used)
    return PlainMesh(
        points, cells, shape, degree, np.concatenate(rows), tuple(groups), named_curves, named
    )


def _cells(kind: int, entities: Sequence[int], width: int) -> IntArray:
    """Node numbers of all cells of a kind, (c, width), filled with -1."""
    tables = [gmsh.model.mesh.getElementsByType(kind, entity)[1] for entity in entities]
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *tables]).astype(np.int64)
    nodes = nodes.reshape(-1, CELLS[kind][2])
    return np.pad(nodes, ((0, 0), (0, width - nodes.shape[1])), constant_values=-1)


def _check_kinds(where: str) -> None:
    if len(gmsh.model.mesh.getElementTypes(3)):
        raise MeshError(f"{where}: has solid (3-D) cells, expected a mesh of surfaces only")
    kinds, cells, _ = gmsh.model.mesh.getElements(2)
    if not len(kinds):
        raise MeshError(f"{where}: has no surface cells")
    for kind in kinds:
        if kind not in CELLS:
            name = gmsh.model.mesh.getElementProperties(kind)[0]
            raise MeshError(
                f"{where}: has cells of kind {name!r}, expected triangles or quadrilaterals of "
                "degree 1 or 2 (gmsh: Mesh.ElementOrder = 2;)"
            )
    whole = all_found(cells, "Triangles", "Quadrangles")
    if set(kinds) == {2, 3} and whole:
        return
    if len({CELLS[kind][0] for kind in kinds}) > 1:
        count = {CELLS[kind][0]: 0 for kind in kinds}
        for kind, of_kind in zip(kinds, cells, strict=True):
            count[CELLS[kind][0]] += len(of_kind)
        raise MeshError(
            f"{where}: mixes {count['triangle']} triangles and {count['quadrilateral']} "
            "quadrilaterals: only those of degree 1 may be mixed. In gmsh, remove every "
            "`Recombine` for triangles only, or set Mesh.SubdivisionAlgorithm = 1;"
        )
    if len(kinds) > 1 or not whole:
        raise MeshError(f"{where}: mixes cells of degree 1 and 2, or with 8 and 9 nodes")


def all_found(cells: Sequence[IntArray], *shapes: str) -> bool:
    """Whether getElements has returned all cells of some shapes (Triangles, Quadrangles, ...).

    gmsh takes the cells of an entity for those of the degree of its first one: getElements leaves
    others out, and getElementsByType reads or writes beyond its arrays.
    """
    count = sum(gmsh.option.getNumber(f"Mesh.Nb{shape}") for shape in shapes)
    return sum(map(len, cells)) == count


def _surface_groups(where: str) -> dict[str, list[int]]:
    """Physical surfaces and their entities; raises MeshError if there are none."""
    groups = physical(2)
    if not groups:
        raise MeshError(
            f"{where}: no physical surface, expected one for each region, such as "
            'Physical Surface("section") = {1}; (and no Mesh.SaveAll when saving)'
        )
    return groups


def physical(dimension: int) -> dict[str, list[int]]:
    """Physical groups by name, or by number if unnamed, and their entities."""
    return {
        gmsh.model.getPhysicalName(dimension, tag) or str(tag): [
            int(entity) for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
        ]
        for _, tag in gmsh.model.getPhysicalGroups(dimension)
    }


def _check_membership(groups: Mapping[str, Sequence[int]], where: str) -> None:
    """Check that every surface with cells is in exactly one group; gmsh returns cells by group."""
    members: dict[int, list[str]] = {}
    for name, entities in groups.items():
        for entity in entities:
            members.setdefault(entity, []).append(name)
    for _, entity in gmsh.model.getEntities(2):
        names = members.get(entity, [])
        if len(names) == 1 or not len(gmsh.model.mesh.getElements(2, entity)[0]):
            continue
        box = gmsh.model.getBoundingBox(2, entity)
        place = (
            f"surface {entity}, from ({box[0]:.4g}, {box[1]:.4g}) to ({box[3]:.4g}, {box[4]:.4g}),"
        )
        listed = ": " + " and ".join(map(repr, names)) if names else ""
        raise MeshError(
            f"{where}: {place} is in {len(names)} physical groups{listed}; expected exactly one, "
            "the region of its material"
        )


def check_mesh(points: Array, tags: IntArray, corners: IntArray, where: str) -> None:
    """Refuse a mesh with which DOLFINx crashes or never ends.

    Parameters
    ----------
    points : (n, 3) nodes
    tags : (n,) their numbers in the file
    corners : (c, k) rows of points
    where : file, for messages

    Raises
    ------
    MeshError
        A coordinate that is not finite; cells that are there twice.
    """
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size:
        raise MeshError(
            f"{where}: node {tags[wrong[0]]} at {points[wrong[0]].tolist()}: expected finite "
            f"coordinates; wrong nodes: {wrong.size}"
        )
    nodes = np.sort(corners, axis=1)
    order = np.lexsort(nodes.T)
    twice = order[1:][(np.diff(nodes[order], axis=0) == 0).all(axis=1)]
    if twice.size:
        raise MeshError(
            f"{where}: {twice.size} cells have the corners of another one, as at "
            f"{points[corners[twice[0]].max()].tolist()}: a part is in two physical groups, or is "
            "meshed twice"
        )


def _in_plane(points: Array, where: str) -> Array:
    """The x, y of points that must lie on z = 0, (n, 2)."""
    size = float(np.ptp(points[:, :2], axis=0).max())
    far = int(np.argmax(np.abs(points[:, 2])))
    if not abs(points[far, 2]) <= 1e-9 * size:
        x, y, z = points[far]
        raise MeshError(
            f"{where}: node at ({x:.4g}, {y:.4g}, {z:.4g}) is not in the plane z = 0; a section is "
            "meshed with x = x2, y = x3 and z = 0"
        )
    return np.ascontiguousarray(points[:, :2])


def curves(tags: IntArray, points: Array, gdim: int) -> dict[str, Array]:
    """Line elements of every physical curve of the current gmsh model by name, (s, 2 or 3, gdim).

    Parameters
    ----------
    tags : (n,) numbers of all nodes in gmsh, ascending
    points : (n, 3) their positions
    gdim : 2 or 3 coordinates are kept
    """
    lines = {name: _line_tags(entities) for name, entities in physical(1).items()}
    places = {name: points[np.searchsorted(tags, own), :gdim] for name, own in lines.items()}
    return {name: ends for name, ends in places.items() if ends.size}


def _line_tags(entities: Sequence[int]) -> IntArray:
    """Node numbers of the line elements of some curves, (s, 2 or 3)."""
    pieces = []
    for entity in entities:
        kinds, _, nodes = gmsh.model.mesh.getElements(1, entity)
        for kind, table in zip(kinds, nodes, strict=True):
            if kind in LINES:
                pieces.append(np.reshape(table, (-1, LINES[kind])))
    if len({piece.shape[1] for piece in pieces}) != 1:
        return np.zeros((0, 2), dtype=np.int64)
    return np.concatenate(pieces).astype(np.int64)


def _named_nodes(tags: IntArray, used: IntArray) -> NamedNodes:
    """Nodes of physical curves and points, as rows of the nodes that cells use."""
    row = np.full(len(tags), -1)
    row[used] = np.arange(len(used))
    curves, points = {}, {}
    for name, entities in physical(1).items():
        curves[name] = row[np.searchsorted(tags, _line_tags(entities))]
    for _, tag in gmsh.model.getPhysicalGroups(0):
        name = gmsh.model.getPhysicalName(0, tag) or str(tag)
        nodes = gmsh.model.mesh.getNodesForPhysicalGroup(0, tag)[0].astype(np.int64)
        points[name] = row[np.searchsorted(tags, nodes)]
    return NamedNodes(tags[used], curves, points)


MESH_HEAD = b"$MeshFormat"
_session_depth = 0

MOST_CELLS = 1_000_000  # of a script's mesh: more take hours and tens of gigabytes to solve
MOST_MEMORY = 3 * 2**30  # of gmsh for its curves [B]; a mesh of MOST_CELLS takes half of that
LONGEST = 120.0  # to mesh the curves [s]
LARGEST = 1e8  # of a parameter: gmsh counts elements of a curve with 32 bits, then begins again


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """A gmsh session without terminal output and without the user's option files; may be nested."""
    global _session_depth
    if _session_depth == 0:
        keywords = {"readConfigFiles": False}
        if "interruptible" in inspect.signature(gmsh.initialize).parameters:
            keywords["interruptible"] = False  # Python keeps handling Ctrl-C
        gmsh.initialize([], **keywords)
        gmsh.option.setNumber("General.Terminal", 0)
    _session_depth += 1
    try:
        yield gmsh
    finally:
        _session_depth -= 1
        if _session_depth == 0:
            gmsh.finalize()


def check_count(path: Path, parameters: Mapping[str, Any]) -> None:
    """Raise MeshError for a script of the user that asks for more than MOST_CELLS cells.

    gmsh meshes until the memory is used up, so a process of its own meshes the curves first. Other
    errors of the script are left to the run itself.
    """
    numbers = {key: np.asarray(value).tolist() for key, value in parameters.items()}
    given = few(f"{key} = {value}" for key, value in numbers.items())
    asked = f"mesh.parameters ({given})" if given else "its mesh sizes"
    limit = f"expected at most {MOST_CELLS} cells"
    for key, value in parameters.items():
        if not isinstance(value, str) and np.abs(np.asarray(value, float)).max(initial=0) > LARGEST:
            raise MeshError(
                f"{path}: mesh.parameters.{key} = {value}: expected a number up to {LARGEST:g}; "
                f"as a density or a number of elements it asks for more than {MOST_CELLS} cells"
            )
    text = f"the mesh of the curves takes more than {MOST_MEMORY / 2**30:g} GB"
    try:
        count = apart(_counted, path, numbers)
    except MemoryError:
        raise MeshError(f"{path}: {asked}: {text}, {limit}") from None
    except GmshEndedError as error:
        if error.code >= 0:  # the script has ended Python
            return
        if error.code == -signal.SIGXCPU:
            text = f"the curves alone take more than {LONGEST:g} s to mesh"
        raise MeshError(f"{path}: {asked}: {text}, {limit}") from None
    if count is not None:
        check_size(count, f"{path}: {asked}")


def _counted(path: Path, parameters: Parameters) -> float | None:
    """Number of cells of a script; None for an error, which the run will show."""
    allow(LONGEST, MOST_MEMORY)
    with gmsh_session():
        try:
            return cell_count(str(path), parameters)
        except MemoryError:
            raise
        except Exception:  # the script of a user, and gmsh, raise anything
            return None


def check_size(count: float, what: str) -> None:
    """Raise MeshError for more cells than MOST_CELLS; `what` names file, key and value."""
    if count > MOST_CELLS:
        about = f"about {count:.1e} cells" if np.isfinite(count) else "far too many cells"
        raise MeshError(f"{what}: the mesh would have {about}, expected at most {MOST_CELLS}")


def surface_mesh(
    path: Path, parameters: Mapping[str, Any], gdim: int, *more: Any, counted: bool = True
) -> PlainMesh:
    """The mesh of a script of gmsh, of a `build(gmsh, parameters, *more)` in Python, or of a file.

    Parameters
    ----------
    counted : the cells of a script are counted before it runs, see `check_count`

    Raises
    ------
    MeshError : as of `run_script` and `open_mesh`; scripts are refused; the script fails.
    """
    if is_refused(path):
        raise MeshError(f"{path}: expected no script with --no-scripts")
    if counted and path.suffix in SUFFIXES:
        check_count(path, parameters)
    if path.suffix == ".geo":
        return run_script(path, parameters, gdim=gdim)
    if path.suffix != ".py":
        return open_mesh(path, gdim=gdim)
    build = getattr(load_script(path), "build", None)
    if build is None or len(inspect.signature(build).parameters) < 2:
        raise MeshError(f"{path}: expected a function build(gmsh, parameters)")
    with gmsh_session():
        gmsh.clear()
        try:
            build(gmsh, dict(parameters), *more)
        except ValueError as error:
            raise MeshError(f"{path.name}: {error}") from error
        except Exception as error:  # a script of the user may raise anything
            lines = traceback.extract_tb(error.__traceback__)
            at = next((f.lineno or 0 for f in reversed(lines) if Path(f.filename) == path), 0)
            raise MeshError(
                f"{path.name}: build(gmsh, parameters) failed in line {at} with "
                f"{type(error).__name__}: {error}"
            ) from error
        if not len(gmsh.model.mesh.getElementTypes(2)):
            gmsh.model.mesh.generate(2)
        plain = plain_from_model(str(path), gdim)
        gmsh.clear()
        return plain


def run_script(path: Path, parameters: Parameters, *, gdim: int = 2) -> PlainMesh:
    """Mesh a gmsh script with values for its parameters.

    Parameters
    ----------
    path : a .geo file with DefineConstant entries named "Parameters/<key>"
    parameters : value of each <key>, a number or a list of numbers
    gdim : of the space

    Raises
    ------
    MeshError : missing file, unknown parameter, gmsh error, a model without a mesh of regions.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such gmsh script")
    text = path.read_text(encoding="utf-8", errors="replace")
    for key in parameters:
        if f'"Parameters/{key}"' not in text:
            raise MeshError(f"{path}: the script has no parameter {key}")
    if is_ours(path):
        return _meshed(path, parameters, gdim)
    try:  # gmsh reads a Macro once per process, and keeps the remains of a faulty script
        return cast(PlainMesh, apart(_meshed, path, parameters, gdim))
    except GmshEndedError as error:
        raise MeshError(f"{path}: {error} while it meshes the script") from None


def _meshed(path: Path, parameters: Parameters, gdim: int) -> PlainMesh:
    """See `run_script`."""
    with gmsh_session():
        gmsh.clear()
        try:
            generate(str(path), parameters)
        except Exception as error:  # gmsh raises bare Exception or ValueError
            raise MeshError(f"{path}: gmsh: {error}") from error
        return plain_from_model(str(path), gdim)


def open_mesh(path: Path, *, gdim: int = 2) -> PlainMesh:
    """Read a surface mesh of gmsh, see `opened`.

    Raises
    ------
    MeshError : missing file, no mesh of gmsh, gmsh error, a model without a mesh of regions.
    """
    with opened(path):
        return plain_from_model(str(path), gdim)


@contextmanager
def opened(path: Path) -> Iterator[None]:
    """Read a mesh of gmsh (.msh from version 2) as the current model; nothing in it is executed.

    Nor is anything beside it. gmsh decides by name and content what a file is: it runs what is not
    a mesh as a script, and FILE.opt, too. It gets a copy that begins as a mesh does, alone in a
    private folder.

    Raises
    ------
    MeshError : missing file, no mesh of gmsh, gmsh error.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such mesh file")
    content = path.read_bytes()
    if not content.startswith(MESH_HEAD):
        raise MeshError(f"{path}: not a mesh of gmsh, expected $MeshFormat as its first bytes")
    _check_names(content, path)
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder, gmsh_session():
        copy = Path(folder) / "mesh.msh"
        copy.write_bytes(content)
        gmsh.clear()
        try:
            gmsh.open(str(copy))
        except Exception as error:  # gmsh raises bare Exception or ValueError
            raise MeshError(f"{path}: gmsh: {str(error).replace(str(copy), path.name)}") from error
        yield
        gmsh.clear()


_NAMES = re.compile(rb"\$PhysicalNames\s(.*?)\$EndPhysicalNames", re.DOTALL)
_SURFACE = re.compile(rb'^\s*2\s+(\d+)\s+"(.*)"\s*$', re.MULTILINE)


def _check_names(content: bytes, path: Path) -> None:
    """Error for two groups of one name: gmsh would drop the second name without a message."""
    block = _NAMES.search(content)  # text in binary files too
    numbers: dict[bytes, bytes] = {}
    for number, name in _SURFACE.findall(block[1]) if block else []:
        if name in numbers:
            raise MeshError(
                f"{path}: two physical surfaces, {numbers[name].decode()} and {number.decode()}, "
                f"are named {name.decode('utf-8', 'replace')!r}: give each region its own name"
            )
        numbers[name] = number
