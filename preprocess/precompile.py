"""Compile what DOLFINx needs of sections, shells and solids, before their first analysis.

An analysis compiles what it lacks by itself, once a machine; the C compiler takes 0.1 to 7 s for
each text. `make fenicsx` and `python -m plymotion.preprocess compile` do it on all cores, for all
cells and elements that descriptions name without unusual settings (higher degrees, other rules).
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..solver.package.body.package_schema import MASS_FORMS
from ..solver.package.shell import elements
from ..solver.system.platform import cores, processes
from .fenicsx import NODES, PlainMesh

SOLIDS = ("tetrahedron", "hexahedron")


def compile_ahead(say: Callable[[str], None]) -> None:
    """Compile all; tell what was done.

    Raises
    ------
    MissingFenicsx : FEniCSx or a C compiler is missing.
    """
    begin = time.perf_counter()
    tasks: list[tuple[Any, ...]] = [(_shell, *words) for words in lists_of_shells()]
    tasks += [(section, cell) for cell in NODES] + [(solid, cell) for cell in SOLIDS]
    tasks += [(surface, cell) for cell in NODES]
    with processes(cores(), fresh=True) as pool:
        for done in [pool.submit(*task) for task in tasks]:
            done.result()
    say(f"texts of {len(tasks)} cells and elements ready in {time.perf_counter() - begin:.1f} s")


def section(cell: str) -> None:
    """Compile the functions, and the strains of twisted beams, of a straight and a curved cell.

    For a field of the default degree 2 and for its estimate, which also takes it at the points of
    degree 3.
    """
    from .section.helical import TwistedStrains
    from .section.space.section_cells import FULL, KINDS, CellMesh
    from .section.space.space import SectionSpace

    kind = np.array([KINDS.index(cell)])
    nodes = np.arange(9)[None, :]
    nodes[0, FULL[kind[0]] :] = -1
    for bulge in (0.0, 0.1):
        points = NODES[cell] / 2.0
        points[len(points) // 2, 1] -= bulge  # the middle of the first edge
        mesh = CellMesh(points, nodes, kind, np.zeros(1, dtype=np.int64), ("",))
        coarse, rich = (SectionSpace(mesh, degree) for degree in (2, 3))
        for space in (coarse, rich, SectionSpace(mesh, 2, rich.quadrature_degree)):
            TwistedStrains(space, np.zeros(3)).S.sum()


def lists_of_shells() -> list[tuple[int, str, str]]:
    """Arguments of `_shell` for all elements; those that take longest come first."""
    from .shell.elements.drilling import DRILLINGS
    from .shell.elements.membranes import MEMBRANES
    from .shell.elements.plates import PLATES

    lists = [(4, "quadrilateral", name) for name in elements.QUADS]
    lists += [(3, "plate", name) for name in PLATES]
    lists += [(3, "membrane", name) for name in MEMBRANES]
    lists += [(3, "drilling", name) for name in DRILLINGS]
    for k in (3, 4):
        lists += [(k, "mass", form) for form in MASS_FORMS]
        lists += [(k, "geometric", ""), (k, "pressure", "")]
    return lists


def _shell(k: int, kind: str, name: str) -> None:
    """Compile one list of a shell element."""
    from .shell.elements.pairs import kernel_of

    kernel_of(k, (kind, name))


def surface(cell: str) -> None:
    """Compile the unknowns at the corners of the cells of shells."""
    from .fenicsx.assembly import Surface

    corners = NODES[cell][(NODES[cell] != 1).all(axis=1)] / 2.0  # others are middles
    Surface(np.pad(corners, ((0, 0), (0, 1))), np.arange(len(corners))[None])


def solid(cell: str) -> None:
    """Compile stiffness and mass of a solid."""
    from .fenicsx.assembly import SolidSpace
    from .solid.forms import MASS_DEGREE, Elasticity, mass, stiffness_rule
    from .solid.solid_mesh import reference_nodes

    points = reference_nodes(cell)
    rows = np.arange(len(points))[None, :]
    plain = PlainMesh(points, rows, cell, 2, np.zeros(1, dtype=np.int64), ("",))
    for degree in (2, 3):
        space = SolidSpace(plain, degree)
        C, rho = space.of_cells(np.eye(6)[None]), space.of_cells(np.ones(1))
        space.matrix(Elasticity(C, stiffness_rule(cell, degree)).stiffness(space.space))
        space.matrix(mass(space.space, rho, MASS_DEGREE + 2 * (degree - 2)))
