"""UFL forms assembled by DOLFINx, and meshes for them: a second formulation for tests."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import scipy.sparse as sp

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx import spaces
from plymotion.preprocess.fenicsx.spaces import LabelledMesh, labelled_mesh


def mesh_from_geo(path: Path, parameters: dict[str, Any]) -> LabelledMesh:
    """Mesh a gmsh script with values for its parameters."""
    return labelled_mesh(fenicsx.run_script(path, parameters, gdim=2))


def assembled(forms: Sequence[Any]) -> list[sp.csr_matrix]:
    """Assemble bilinear forms without boundary conditions."""
    return [spaces.assembled(form) for form in forms]
