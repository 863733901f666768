"""What the light side must know of gmsh's files: the names in a mesh, the content of a script."""

import hashlib
import re
from pathlib import Path

from ..errors import InputError

_NAMES = re.compile(rb"\$PhysicalNames\s(.*?)\$EndPhysicalNames", re.DOTALL)
_NAME = re.compile(rb'^\s*(\d+)\s+(\d+)\s+"(.*)"\s*$', re.MULTILINE)
_OTHER = re.compile(r'^\s*(?:Merge|Include)\s+"([^"]+)"', re.MULTILINE)


def is_gmsh_mesh(file: Path) -> bool:
    """Tell gmsh's .msh from those of other programs."""
    with file.open("rb") as stream:
        return stream.read(64).lstrip().startswith(b"$MeshFormat")


def physical_names(file: Path, where: str) -> tuple[list[str], list[str]]:
    """Return the names of the physical surfaces and of the physical curves of a .msh file.

    `where` is its key, for messages.

    Raises
    ------
    InputError
        No physical surface has a name.
    """
    block = _NAMES.search(file.read_bytes())  # text in binary files too
    found = _NAME.findall(block[1]) if block else []
    by_dimension = [
        [name.decode("utf-8", "replace") for dimension, _, name in found if int(dimension) == d]
        for d in (2, 1)
    ]
    if not by_dimension[0]:
        raise InputError(
            f"{where}: no physical surface of it has a name, expected one per region, "
            'like Physical Surface("skin") = {1};'
        )
    return by_dimension[0], by_dimension[1]


def content_sha256(file: Path) -> str:
    """Return the hash of a mesh file, or of a script with all that it merges and includes.

    The hash of a file alone is that of its bytes.
    """
    parts = [file.read_bytes()]
    if file.suffix == ".geo":
        pending, seen = [file], {file.resolve()}
        while pending:
            script = pending.pop()
            text = script.read_text(encoding="utf-8", errors="replace")
            for name in _OTHER.findall(text):
                other = script.parent / name
                if other.is_file() and other.resolve() not in seen:
                    seen.add(other.resolve())
                    parts.append(other.read_bytes())
                    if other.suffix in (".geo", ".pro"):
                        pending.append(other)
    if len(parts) == 1:
        return hashlib.sha256(parts[0]).hexdigest()
    return hashlib.sha256(b"".join(hashlib.sha256(p).digest() for p in parts)).hexdigest()
