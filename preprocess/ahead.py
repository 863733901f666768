"""Compile what DOLFINx needs of sections and shells, before their first analysis.

An analysis compiles what it lacks by itself, once a machine; the C compiler takes 0.2 to 3 s for
each expression. This does it for all cells and elements that descriptions name without unusual
settings (higher degrees, other rules), on all cores.
"""

import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context

import numpy as np

from ..solver.math.cores import cores
from ..solver.package.body.schema import MASS_FORMS

DEGREES = (2, 3)  # of the field of a section, and of its error estimate
RECOVERY_DEGREE = 3  # of the rule of stress recovery in packages
CURVATURE = np.array([0.1, 0.02, 0.03])
NODES = {  # of one cell, corners, middles of the edges, centre
    0: [[0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]],
    1: [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]],
}


def compile_ahead(say: Callable[[str], None]) -> None:
    """Compile all; tell what was done.

    Raises
    ------
    MissingFenicsx : FEniCSx or a C compiler is missing.
    """
    begin = time.perf_counter()
    tasks = [*_of_shells(), *_of_sections()]
    with ProcessPoolExecutor(cores(), get_context("spawn")) as pool:
        for done in [pool.submit(task, *words) for task, *words in tasks]:
            done.result()
    say(f"{len(tasks)} sets of forms ready in {time.perf_counter() - begin:.1f} s")


def _of_sections() -> list[tuple]:  # type: ignore[type-arg]
    rules = [(d, 2 * d + more) for d in DEGREES for more in (0, 2)]
    rules += [(DEGREES[0], RECOVERY_DEGREE)]
    return [(section, kind, *rule) for kind, rule in product(NODES, [*rules, (None, None)])]


def section(kind: int, degree: int | None, rule: int | None) -> None:
    """Compile the functions, and the strains of twisted beams, of one kind of cell."""
    from .section.cells import ABSENT, MOST_NODES, CellMesh
    from .section.space import SectionSpace
    from .section.twist import TwistedStrains

    points = np.array(NODES[kind], dtype=float)
    nodes = np.full((1, MOST_NODES), ABSENT)
    nodes[0, : len(points)] = np.arange(len(points))
    zero = np.zeros(1, dtype=np.int64)
    space = SectionSpace(CellMesh(points, nodes, zero + kind, zero, ("all",)), degree, rule)
    _ = TwistedStrains(space, CURVATURE).S


def _of_shells() -> list[tuple]:  # type: ignore[type-arg]
    from .shell.drilling import DRILLINGS
    from .shell.membranes import MEMBRANES
    from .shell.plates import PLATES
    from .shell.quads import QUADS

    lists = [(4, "quadrilateral", name) for name in QUADS]
    lists += [(3, "plate", name) for name in PLATES]
    lists += [(3, "membrane", name) for name in MEMBRANES]
    lists += [(3, "drilling", name) for name in DRILLINGS]
    for k in (3, 4):
        lists += [(k, "mass", form) for form in MASS_FORMS]
        lists += [(k, "geometric", ""), (k, "pressure", "")]
    return [(shell, *words) for words in lists]


def shell(k: int, kind: str, name: str) -> None:
    """Compile one list of a shell element."""
    from .shell.pairs import kernel_of

    kernel_of(k, (kind, name))
