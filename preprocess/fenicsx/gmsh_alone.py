"""Scripts of gmsh, and gmsh in a process of its own: it may abort, hang, or use up the memory."""

import faulthandler
import json
import multiprocessing
import os
import re
import runpy
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from ...solver.system.platform import POSIX, context
from .libraries import MeshError, gmsh

STILL = 30.0  # [s] by the clock, twice without processor time: a process waits for ever
FINEST = 1e-7  # size of cells over that of the model, below which no mesh is meant
NAMED = re.compile(r"\b(Merge|Include)\s*[\"']([^\"'\n]+)[\"']")
COMPUTED = re.compile(r"\b(?:Merge|Include)\b(?!\s*[\"'])")
MOST_FOLDERS = 1000  # below that of a script, which are searched for what it could merge
Parameters = Mapping[str, float | Sequence[float]]


class GmshEndedError(Exception):
    """The process of `apart` has ended with a code and no result; below 0: by a signal."""

    def __init__(self, code: int) -> None:
        super().__init__(f"gmsh has ended with {code}")
        self.code = code


def apart(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return the value of a function of a file in a process of its own, a copy on Linux.

    Raises
    ------
    GmshEndedError : a signal, or the end of Python, of that process
    MeshError : it takes no processor time: a copy waits for a lock of a thread that is not copied
    others : as of the function
    """
    copies = context()
    here, there = copies.Pipe(duplex=False)
    copy = copies.Process(target=_send, args=(there, function, arguments))
    copy.start()
    there.close()
    spent, still = -1.0, 0
    try:
        while not here.poll(STILL):
            now = _processor_time(copy.pid)
            spent, still = now, still + 1 if now == spent else 0
            if still == 2:  # one alone may be a command that was stopped and goes on
                raise MeshError(f"{arguments[0]}: gmsh waits without end; start the command again")
        received = here.recv()
    except EOFError:
        copy.join()
        raise GmshEndedError(copy.exitcode) from None
    finally:
        copy.kill()
        copy.join()
    if isinstance(received, Exception):
        raise received
    return received


def _processor_time(pid: int) -> float:
    """Processor time of another process [s]; NaN where it cannot be read."""
    try:
        return time.clock_gettime(~pid << 3 | 2)  # as clock_getcpuclockid of Linux
    except (AttributeError, OSError):
        return float("nan")


def _send(there: Any, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    faulthandler.disable()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # OpenCASCADE's words, and MPI's of a signal
    try:
        outcome = function(*arguments)
    except Exception as error:  # raised again in the other process
        outcome = error
    there.send(outcome)


def allow(seconds: float, memory: int | None = None) -> None:
    """End this process after more processor time, or limit further memory [B], in `apart`."""
    if not POSIX or multiprocessing.parent_process() is None:
        return
    import resource

    limits = {resource.RLIMIT_CPU: int(time.process_time() + seconds) + 1, resource.RLIMIT_CORE: 0}
    if memory is not None and os.path.exists("/proc/self/statm"):
        with open("/proc/self/statm", encoding="ascii") as file:
            pages = int(file.read().split()[0])
        limits[resource.RLIMIT_AS] = pages * resource.getpagesize() + memory
    for kind, limit in limits.items():
        resource.setrlimit(kind, (limit, resource.getrlimit(kind)[1]))


def define(parameters: Parameters) -> None:
    """Set the values of "Parameters/<key>" that the next script reads."""
    numbers = [
        {
            "type": "number",
            "name": f"Parameters/{key}",
            "values": np.atleast_1d(np.asarray(value, dtype=float)).tolist(),
        }
        for key, value in parameters.items()
    ]
    gmsh.onelab.clear()
    gmsh.onelab.set(json.dumps(numbers))


def read(script: str) -> None:
    """Run a script, and not SCRIPT.opt beside it, which gmsh runs with each file that it merges."""
    _refuse_options(os.path.abspath(script))
    quote = "'" if '"' in script else '"'  # gmsh has no escapes within quotes
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        outer = os.path.join(folder, "script.geo")
        with open(outer, "wb") as file:
            file.write(os.fsencode(f"Include {quote}{os.path.abspath(script)}{quote};\n"))
        gmsh.merge(outer)


def _refuse_options(script: str, known: frozenset[str] = frozenset()) -> None:
    """Raise ValueError if a FILE that a script merges has a FILE.opt.

    A script that computes a name could merge any FILE of its folder and of those below.
    """
    if script in known or not os.path.isfile(script):
        return
    with open(script, encoding="utf-8", errors="replace") as file:
        text = file.read()
    for word, name in NAMED.findall(text):
        path = os.path.join(os.path.dirname(script), name)
        if word == "Include":
            _refuse_options(path, known | {script})
        elif os.path.lexists(f"{path}.opt"):
            raise ValueError(
                f'Merge "{name}" would run {path}.opt as a script: expected no such file'
            )
    if COMPUTED.search(text):
        for folder, _, names in islice(os.walk(os.path.dirname(script)), MOST_FOLDERS):
            for name in names:
                path = os.path.join(folder, name)
                if name.endswith(".opt") and os.path.lexists(path.removesuffix(".opt")):
                    raise ValueError(
                        f"{script} computes the name of a file that it merges; with that of "
                        f"{path.removesuffix('.opt')} gmsh would run {path} as a script: expected "
                        "no such file"
                    )


def generate(script: str, parameters: Parameters) -> None:
    """Mesh a script with values for its "Parameters/<key>" in the current model."""
    define(parameters)
    read(script)
    gmsh.model.mesh.generate(2)
    gmsh.onelab.clear()


def cell_count(script: str, parameters: Parameters) -> float:
    """About how many cells the mesh of a script would have; its curves are meshed."""
    if script.endswith(".py"):
        runpy.run_path(script)["build"](gmsh, parameters)
    else:
        define(parameters)
        read(script)
    made = sum(len(tags) for tags in gmsh.model.mesh.getElements(2)[1])
    if made:
        return float(made)
    gmsh.model.mesh.generate(1)
    low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    if gmsh.option.getNumber("Mesh.MeshSizeMax") < FINEST * np.linalg.norm(high - low):
        return np.inf  # gmsh divides nothing by a size below its tolerance
    return sum(_cells_of(tag) for _, tag in gmsh.model.getEntities(2))


def _cells_of(surface: int) -> float:
    """Area within the edges, over that of an equilateral triangle of their mean length."""
    start, end = [], []
    for _, curve in gmsh.model.getBoundary([(2, surface)], oriented=True):
        kinds, _, nodes = gmsh.model.mesh.getElements(1, abs(curve))
        for kind, tags in zip(kinds, nodes, strict=True):
            known, places, _ = gmsh.model.mesh.getNodes(1, abs(curve), includeBoundary=True)
            row = dict(zip(known.tolist(), places.reshape(-1, 3), strict=True))
            n = gmsh.model.mesh.getElementProperties(kind)[3]
            ends = np.array([row[tag] for tag in tags.tolist()]).reshape(-1, n, 3)
            a, b = (ends[:, 0], ends[:, 1]) if curve > 0 else (ends[:, 1], ends[:, 0])
            start.append(a)
            end.append(b)
    if not start:
        return 0.0
    a, b = np.concatenate(start), np.concatenate(end)
    area = 0.5 * float(np.linalg.norm(np.cross(a - a[0], b - a[0]).sum(axis=0)))
    mean = float(np.linalg.norm(b - a, axis=1).mean())
    return max(area / (0.25 * np.sqrt(3.0) * mean**2), float(len(a)))
