"""Run gmsh: scripts with parameters, and mesh files."""

import inspect
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.errors import few
from ..errors import MeshError
from ..plain import PlainMesh
from ..stack import gmsh
from . import gmsh_alone
from .gmsh_alone import Parameters, generate
from .gmsh_model import plain_from_model

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
        keywords: dict[str, Any] = {"readConfigFiles": False}
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
    command = [sys.executable, gmsh_alone.__file__, str(path.absolute()), json.dumps(numbers)]
    command += ["--count", str(MOST_MEMORY)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        text = f"the curves alone take more than {LONGEST:g} s to mesh"
        raise MeshError(f"{path}: {asked}: {text}, {limit}") from None
    if done.returncode < 0 or "MemoryError" in done.stderr:
        text = f"the mesh of the curves takes more than {MOST_MEMORY / 2**30:g} GB"
        raise MeshError(f"{path}: {asked}: {text}, {limit}")
    try:
        count = float(done.stdout.split()[-1])
    except (IndexError, ValueError):  # another error, which the run will show
        return
    check_size(count, f"{path}: {asked}")


def check_size(count: float, what: str) -> None:
    """Raise MeshError for more cells than MOST_CELLS; `what` names file, key and value."""
    if count > MOST_CELLS:
        about = f"about {count:.1e} cells" if np.isfinite(count) else "far too many cells"
        raise MeshError(f"{what}: the mesh would have {about}, expected at most {MOST_CELLS}")


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
    with gmsh_session():
        gmsh.clear()
        try:
            generate(str(path), parameters)
        except Exception as error:  # gmsh raises bare Exception or ValueError
            _flush_parser()
            if "Redefinition of function" not in str(error):
                raise MeshError(f"{path}: gmsh: {error}") from error
        else:
            plain = plain_from_model(str(path), gdim)
            gmsh.clear()
            return plain
    # gmsh reads a script with a Macro only once per process, because it keeps the name
    return _run_alone(path, parameters, gdim)


def _flush_parser() -> None:
    """Clear the remains of a faulty script from gmsh's parser; they would affect the next script.

    Every attempt to read an empty script removes the remains up to the next error.
    """
    with tempfile.TemporaryDirectory() as folder:
        empty = Path(folder) / "empty.geo"
        empty.write_text("\n")
        for _ in range(100):
            try:
                gmsh.merge(str(empty))
            except Exception:  # gmsh raises bare Exception or ValueError
                continue
            return


def _run_alone(path: Path, parameters: Parameters, gdim: int) -> PlainMesh:
    """`run_script` in a separate process."""
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "mesh.msh"
        numbers = json.dumps({key: np.asarray(v).tolist() for key, v in parameters.items()})
        command = [sys.executable, gmsh_alone.__file__, str(path.absolute()), numbers]
        done = subprocess.run([*command, str(mesh)], capture_output=True, text=True)
        if done.returncode != 0:
            reason = (done.stderr.strip().splitlines() or ["no mesh"])[-1]
            raise MeshError(f"{path}: gmsh: {reason.removeprefix('Exception: ')}")
        with gmsh_session():
            gmsh.clear()
            gmsh.open(str(mesh))
            plain = plain_from_model(str(path), gdim)
            gmsh.clear()
        return plain


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
