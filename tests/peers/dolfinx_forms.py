"""UFL forms assembled by DOLFINx: a second formulation for tests."""

from collections.abc import Sequence
from typing import Any

import scipy.sparse as sp

from plymotion.preprocess.fenicsx import spaces


def assembled(forms: Sequence[Any]) -> list[sp.csr_matrix]:
    """Assemble bilinear forms without boundary conditions."""
    return [spaces.assembled(form) for form in forms]
