"""`[fidelity]` of a case file: what the user wants to know and how well."""

from typing import Literal

from pydantic import Field

from ..common.table import Name, Table, unit

Metric = Literal["pointwise", "extremum", "rms"]


class Fidelity(Table):
    """`[fidelity]`: the accuracy that a run must have; docs/fidelity.md."""

    accuracy: float = Field(
        gt=0, lt=1, description="accepted error of a signal, of its largest value"
    )
    signals: list[Name] | None = Field(
        default=None, min_length=1, description="the signals that must have it; absent: all"
    )
    metric: Metric = Field(
        default="pointwise",
        description="how two histories are compared: pointwise: largest difference at one time; "
        "extremum: difference of their largest and smallest values; rms: root mean square",
    )
    budget: float = Field(
        default=10.0,
        gt=0,
        description="CPU time of plan and check; no new run begins after it",
        json_schema_extra=unit("s"),
    )
