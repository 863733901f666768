"""Figures of `make fidelity` over the requests of some scenes."""

from itertools import pairwise
from typing import Any

import numpy as np

Table = dict[str, Any]


def totals(scenes: Table) -> Table:
    """Return the figures over some scenes."""
    pairs = [(scene, request) for scene in scenes.values() for request in scene["requests"]]
    requests = [request for _, request in pairs]
    accepted = [r for r in requests if r["verdict"] == "met"]
    ratios = [r["estimate"] / r["true"] for r in accepted if r["true"] > 0.0]
    costs = [r["model_s"] / r["cheapest_s"] for r in accepted if r["cheapest_s"]]
    whole = [(r["model_s"] + r["check_s"]) / s["all_modes_s"] for s, r in pairs if r["check_s"]]
    everything = [r["all_s"] / s["all_modes_s"] for s, r in pairs]
    indicators, plans = (
        [r[f"{part}_s"] / s["rigid_s"] for s, r in pairs] for part in ("indicators", "plan")
    )
    refused = [r for r in requests if r["verdict"] != "met"]
    return {
        "requests": len(requests),
        "accepted": len(accepted),
        "met": sum(bool(r["true"] <= r["accuracy"]) for r in accepted),
        "false_refusals": sum(bool(r["true"] <= r["accuracy"]) for r in refused),
        "effectivity": quantiles(ratios),
        "effectivity_within": sum(bool(0.5 <= r <= 3.0) for r in ratios),
        "cost_ratio_median": median(costs),
        "all_in_ratio_median": median(whole),
        "all_rounds_ratio_median": median(everything),
        "indicators_over_rigid_median": median(indicators),
        "planning_over_rigid_median": median(plans),  # with the rigid run and the choice
        "delivered_met": sum(bool(r["delivered"] <= r["accuracy"]) for r in requests),
        "worse_when_tighter": worse_when_tighter(scenes, doubts=0.0),
        # The error of either result is known to the doubt of the truth.
        "worse_beyond_doubt": worse_when_tighter(scenes, doubts=2.0),
    }


def by(key: str, scenes: Table) -> dict[str, Table]:
    """Return requests, accepted, met, delivered_met for each value of a key of the requests."""
    found: dict[str, Table] = {}
    for scene in scenes.values():
        for r in scene["requests"]:
            row = found.setdefault(
                f"{r[key]:g}" if isinstance(r[key], float) else str(r[key]),
                {"requests": 0, "accepted": 0, "met": 0, "delivered_met": 0},
            )
            row["requests"] += 1
            row["delivered_met"] += bool(r["delivered"] <= r["accuracy"])
            if r["verdict"] == "met":
                row["accepted"] += 1
                row["met"] += bool(r["true"] <= r["accuracy"])
    return found


def worse_when_tighter(scenes: Table, doubts: float) -> int:
    """Count tighter requests that are not met and whose delivered result is worse.

    Worse by more than so many `doubts` of the truth of the signal.
    """
    count = 0
    for scene in scenes.values():
        for output in {r["output"] for r in scene["requests"]}:
            mine = sorted(
                (r for r in scene["requests"] if r["output"] == output),
                key=lambda r: -float(r["accuracy"]),
            )
            least = doubts * scene["doubt"][output]
            for loose, tight in pairwise(mine):
                worse = tight["delivered"] > loose["delivered"] + least
                count += bool(worse and tight["delivered"] > tight["accuracy"])
    return count


def quantiles(values: list[float]) -> list[float] | None:
    """Return the 5 %, median and 95 % of values."""
    return [float(v) for v in np.quantile(values, [0.05, 0.5, 0.95])] if values else None


def median(values: list[float]) -> float | None:
    """Return the median of values."""
    return float(np.median(values)) if values else None
