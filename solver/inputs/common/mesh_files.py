"""Mesh files and scripts that a description names: permission, names of groups, content.

Scripts run with the rights of the user, unless refused.
"""

import contextlib
import hashlib
import re
from collections.abc import Collection, Iterator, Sequence
from contextvars import ContextVar
from pathlib import Path

from ...errors import InputError, few, nearest

SUFFIXES = (".geo", ".py")
ALL = "all"  # every wall or region without its own table
_allowed: ContextVar[bool] = ContextVar("scripts_allowed", default=True)


@contextlib.contextmanager
def scripts(*, allowed: bool) -> Iterator[None]:
    """Allow or refuse scripts in the descriptions that are read inside."""
    token = _allowed.set(allowed)
    try:
        yield
    finally:
        _allowed.reset(token)


def are_refused() -> bool:
    """Return whether scripts are refused, so that the preprocessor refuses them, too."""
    return not _allowed.get()


_NAMES = re.compile(rb"\$PhysicalNames\s(.*?)\$EndPhysicalNames", re.DOTALL)
_NAME = re.compile(rb'^\s*(\d+)\s+(\d+)\s+"(.*)"\s*$', re.MULTILINE)
_GEO = re.compile(r'^\s*(?:Merge|Include)\s+"([^"]+)"', re.MULTILINE)
_PY = re.compile(r"""["']([\w./-]+\.(?:py|geo|dat|csv|txt|json|toml|msh|step|stp))["']""")
_IMPORT = re.compile(r"^\s*(?:from\s+\.?(\w+)\s+import|import\s+(.+))", re.MULTILINE)
_INP = re.compile(r"^\s*\*INCLUDE\b.*INPUT\s*=\s*\"?([^\s\",]+)", re.MULTILINE | re.IGNORECASE)
# How a file names the files that it reads.
_OTHER = {".geo": _GEO, ".pro": _GEO, ".py": _PY, ".inp": _INP}


def library(folder: str) -> Path:
    """Return a folder of meshes/: at the top of a checkout, beside the package in a wheel."""
    return Path(__file__).parents[3] / "meshes" / folder


def mesh_source(name: str, folder: Path) -> tuple[Path, str]:
    """Return the file of `[mesh]`, and its key for messages.

    Raises InputError : a script where none is allowed, no such file, a .msh of another program.
    """
    file, key = folder / name, f'mesh.file = "{name}"'
    if file.suffix in SUFFIXES and not _allowed.get():
        raise InputError(
            f"{key}: expected no script with --no-scripts, it would run commands; a mesh .msh is "
            "only read"
        )
    if not file.is_file():
        raise InputError(f"{key}: there is no file {file}")
    return file, key


def is_gmsh_mesh(file: Path) -> bool:
    """Tell gmsh's .msh from those of other programs, and from scripts, by the first bytes."""
    with file.open("rb") as stream:
        return stream.read(11) == b"$MeshFormat"


def physical_names(file: Path, where: str) -> tuple[list[str], list[str]]:
    """Return the names of the physical surfaces and of the physical curves of a .msh file.

    `where` is its key, for messages.

    Raises
    ------
    InputError
        No physical surface has a name.
    """
    groups = physical_groups(file)
    if not groups[2]:
        raise InputError(
            f"{where}: no physical surface of it has a name, expected one per region, "
            'like Physical Surface("skin") = {1};'
        )
    return groups[2], groups[1]


def physical_groups(file: Path) -> tuple[list[str], list[str], list[str]]:
    """Return the names of the physical points, curves and surfaces of a .msh file."""
    block = _NAMES.search(file.read_bytes())  # text in binary files too
    groups = [
        (int(dimension), name.decode("utf-8", "replace"))
        for dimension, _, name in (_NAME.findall(block[1]) if block else [])
    ]
    points, curves, surfaces = ([name for d, name in groups if d == wanted] for wanted in range(3))
    return points, curves, surfaces


def matched(
    regions: Collection[str], surfaces: Sequence[str], file: str
) -> tuple[dict[str, str], list[str]]:
    """Return the description of each physical surface of a mesh, and what is wrong.

    Parameters
    ----------
    regions : names of the described regions; ALL stands for surfaces without their own
    surfaces : names of the physical surfaces of the mesh
    file : name of the mesh, for messages
    """
    errors = [
        f"regions.{name}: {file} has no physical surface of this name{nearest(name, surfaces)}"
        for name in regions
        if name not in (*surfaces, ALL)
    ]
    names = {name: name if name in regions else ALL for name in surfaces}
    errors += [
        f"regions.{name}: missing; {file} has the physical surfaces {few(surfaces)}"
        for name, described in names.items()
        if described not in regions
    ]
    return names, errors


def files_read(file: Path) -> list[Path]:
    """Return a file and, of a script, all files that it merges, includes, imports or names.

    A Python script reads the files it names in quotes.
    """
    files, seen = [file], {file.resolve()}
    for script in files:
        if script.suffix not in _OTHER:
            continue
        text = script.read_text(encoding="utf-8", errors="replace")
        names = _OTHER[script.suffix].findall(text)
        if script.suffix == ".py":
            words = re.findall(r"\w+", " ".join(" ".join(each) for each in _IMPORT.findall(text)))
            names += [f"{name}.py" for name in words]
        for name in names:
            other = script.parent / name
            if other.is_file() and other.resolve() not in seen:
                seen.add(other.resolve())
                files.append(other)
    return files


def content_sha256(file: Path) -> str:
    """Return the hash of a mesh file, or of a script with all files that it reads.

    The hash of a single file is that of its bytes.
    """
    parts = [each.read_bytes() for each in files_read(file)]
    if len(parts) == 1:
        return hashlib.sha256(parts[0]).hexdigest()
    return hashlib.sha256(b"".join(hashlib.sha256(p).digest() for p in parts)).hexdigest()
