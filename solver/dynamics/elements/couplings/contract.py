"""What the file of a coupling supplies.

A coupling is one equation between the coordinates of two joints, r_1 e_1 + r_2 e_2 = 0, from the
given starting position and over any number of turns. It is one file of this folder with a
`Coupling`; table.py finds it, inputs/case/tables/kinds.py makes its table of the case file.
"""

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

from ....math.catalogue import Number

Unit = Literal["rad", "m"]
ROWS: dict[Unit, str] = {"rad": "r", "m": "d"}  # letters of joints/contract.py


class Coupling(NamedTuple):
    """A coupling of the case file.

    Attributes
    ----------
    kind, meaning, order : as of a joint
    units : of the coordinates of both joints
    keys : of the case file, behind `joints` and `coordinates`
    ratios : f(values by key) -> r_1, r_2
    unit : of the equation r_1 e_1 + r_2 e_2
    """

    kind: str
    meaning: str
    units: tuple[Unit, Unit]
    keys: tuple[Number, ...]
    ratios: Callable[[Mapping[str, Any]], tuple[float, float]]
    unit: Unit
    order: int = 100
