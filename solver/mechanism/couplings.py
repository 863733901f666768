"""Couplings between joints from the tables of a case."""

from typing import TYPE_CHECKING

from ..dynamics.couplings.contract import ROWS
from ..dynamics.couplings.table import COUPLINGS
from ..dynamics.measured import CouplingRow
from ..inputs.case.coupled import coupled
from .measured import Reader

if TYPE_CHECKING:
    from ..inputs.case.schema import Mechanism


def coupling_rows(mechanism: "Mechanism", reader: Reader) -> list[CouplingRow]:
    """Return the couplings in the order of the case; `reader` gets their coordinates."""
    rows = []
    for name, coupling in mechanism.couplings.items():
        kind = COUPLINGS[coupling.kind]
        pair = coupled(name, coupling, mechanism)
        values = {key.name: getattr(coupling, key.name) for key in kind.keys}
        terms = [
            (reader.of_joint(*side), ratio)
            for side, ratio in zip(pair, kind.ratios(values), strict=True)
        ]
        rows.append(CouplingRow(name, ROWS[kind.unit], tuple(terms)))
    return rows
