"""What a study tells in text: the table of a command, and the best design as a variant."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import counted
from ...inputs.case.tables.schema import split_key
from ...report.table import aligned
from ..tolerances import SAME_OBJECTIVE
from .problem import FEASIBLE


def outcome_lines(study: Mapping[str, Any], folder: Path) -> list[str]:
    """Return the lines that the command prints: measures before and after, then parameters."""
    starts, best = study["starts"], study["optimum"]
    total = sum(s["computed"] for s in starts)
    agreeing = sum(
        s["best"] is not None
        and s["best"]["violation"] <= FEASIBLE
        and abs(s["best"]["merit"] - best["merit"]) <= 1e-3 * abs(best["merit"])
        for s in starts
    )
    lines = [
        f"{study['study']}: {counted(len(starts), 'start')}, {counted(total, 'design')} computed; "
        f"{agreeing} of them end{'s' * (agreeing == 1)} within 0.1 % of the best; "
        f"{os.path.relpath(folder)}"
    ]
    verified = study.get("verified", {})
    head = ["", "start", "best", "verified", "limit"]
    rows = [head]
    for k, measure in enumerate(study["measures"]):
        unit = f" [{measure['unit']}]" if measure["unit"] else ""
        sense = f"{study['sense']} " if k == 0 else ""
        values = [study["start"]["shown"], best["shown"], verified.get("shown")]
        limits = ((">=", measure["least"]), ("<=", measure["most"]))
        limit = [f"{sign} {value:g}" for sign, value in limits if value is not None]
        texts = [f"{v[k]:.6g}" if v else "-" for v in values]
        rows.append([f"{sense}{measure['words']}{unit}", *texts, ", ".join(limit)])
    rows.append([""] * 5)
    for k, (name, value) in enumerate(best["values"].items()):
        parameter, first = study["parameters"][name], study["start"]["p"][k]
        names, unit = parameter["names"], f" [{parameter['unit']}]" * bool(parameter["unit"])
        texts = [names[round(first)], value] if names else [f"{first:.6g}", f"{value:.6g}"]
        rows.append([name + unit, *texts, "", ""])
    lines.append(aligned(rows, left=range(5), head=1, rule=False))
    if best["violation"] > FEASIBLE:
        lines.append(
            "no design was found that satisfies all limits: this one breaks one by "
            f"{best['violation']:.3g} of it"
        )
    if _constant(study):
        lines.append(
            f"the objective was {best['shown'][0]:.6g} for all designs, with derivatives of zero: "
            f"does it depend on {', '.join(study['parameters'])}?"
        )
    if verified.get("why"):
        lines.append(f"not verified: {verified['why']}")
    if "plan" in study:
        text = f"the plan of the study: accuracy {study['plan']['verdict']} at the best design"
        same = "the same" if study["plan"]["same"] else "another one"
        lines.append(f"{text}; made anew there it is {same}")
    invalid = list(dict.fromkeys(why for s in starts for why in s["invalid"]))
    if invalid:
        lines.append(f"{counted(len(invalid), 'kind')} of invalid designs, such as: {invalid[0]}")
    lines.append(f"gradient: {study['gradient']}")
    return lines


def _constant(study: Mapping[str, Any]) -> bool:
    """Return whether neither designs nor derivatives changed the objective."""
    merits = np.array([point["merit"] for start in study["starts"] for point in start["history"]])
    low, high = np.array([each["range"] for each in study["parameters"].values()]).T
    slopes = [by[0] * (high - low) for by in study["sensitivities"].values() if by]
    if not merits.size or not slopes:
        return False
    change = max(float(np.ptp(merits)), float(np.abs(slopes).max()))
    return change <= SAME_OBJECTIVE * float(np.abs(merits).max())


def variant_text(study: Mapping[str, Any]) -> str:
    """Return the best design as a variant of the case, in TOML."""
    lines = [
        f"# The best design of study {study['study']}: a variant for the case, to be named in",
        "# `variants` of a run. Keys of lists are comments: write those into the list itself.",
    ]
    tables: dict[str, list[str]] = {}
    for key, value in study["optimum"]["keys"].items():
        *way, last = split_key(key)
        listed = last.isdecimal() or any(part.isdecimal() for part in way)
        text = f'"{last}" = {value!r}' if "." in last else f"{last} = {value!r}"
        if listed:
            tables.setdefault("", []).append(f"# {key} = {value!r}")
        else:
            tables.setdefault(".".join(("variants", study["study"], *way)), []).append(text)
    for table, entries in sorted(tables.items()):
        lines += ["", *([f"[{table}]"] if table else []), *entries]
    return "\n".join(lines) + "\n"
