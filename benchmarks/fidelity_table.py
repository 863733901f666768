"""Write the figures of build/benchmarks/fidelity.json and fidelity-theory.json into a page.

.venv/bin/python benchmarks/fidelity_table.py docs/fidelity.md
"""

import json
import sys
from pathlib import Path

from fidelity_scenes import SCENES, Table

FOLDER = Path("build/benchmarks")
BEGIN, END = "<!-- figures: begin -->\n", "<!-- figures: end -->\n"


def main() -> None:
    """Replace what is between the marks of a page."""
    page = Path(sys.argv[1])
    found = json.loads((FOLDER / "fidelity.json").read_text(encoding="utf-8"))
    theory = json.loads((FOLDER / "fidelity-theory.json").read_text(encoding="utf-8"))
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    after = rest.partition(END)[2]
    text = before + BEGIN + "\n".join([*figures(found), "", *theories(theory)]) + "\n" + END + after
    page.write_text(text, encoding="utf-8")


def figures(found: Table) -> list[str]:
    """Return the tables of all requests."""
    missing = [name for name in SCENES if name not in found["scenes"]]
    held = sum(scene["held"] for scene in found["scenes"].values())
    without = f", without {', '.join(missing)}" if missing else ""
    lines = [
        f"{len(found['scenes'])} scenes{without}:",
        "",
        "| | requests | accepted | met | false refusals | estimate / true 5 %, median, 95 % "
        "| within 0.5 to 3 | chosen / cheapest (CPU) | model + check / all modes "
        "| delivered result meets |",
        "|---|---|---|---|---|---|---|---|---|---|",
        _row("all", found),
        _row(f"the {held} held back", found["held"]),
        "",
        "| by | requests | accepted | met | delivered result meets |",
        "|---|---|---|---|---|",
    ]
    for key, row in {**found["outputs"], **found["accuracies"]}.items():
        counts = row["requests"], row["accepted"], row["met"], row["delivered_met"]
        lines.append(f"| {key} | {' | '.join(map(str, counts))} |")
    costs = [found[f"{part}_median"] for part in ("indicators_over_rigid", "planning_over_rigid")]
    lines += [
        "",
        f"Indicators take {costs[0]:.1f} rigid runs in the median, planning with the base motion "
        f"and the choice {costs[1]:.1f}.",
        f"All rounds of planning take {found['all_rounds_ratio_median']:.2f} of all modes.",
        f"In {found['worse_when_tighter']} pairs of requests the tighter one misses with a larger "
        "error than the other;",
        f"in {found['worse_beyond_doubt']} of them by more than the error of the reference.",
        "",
        "Error of the reference, of the largest value of each signal:",
        "",
        *_by_signal({name: [*scene["doubt"].values()] for name, scene in found["scenes"].items()}),
    ]
    return lines


def _by_signal(rows: dict[str, list[float | str]], *more: str) -> list[str]:
    """Return a table of numbers by signal of each scene; `more` are titles of further columns."""
    titles = ["scene", "tip", "deflection", "force", "moment", *more]
    lines = [f"| {' | '.join(titles)} |", f"|{'---|' * len(titles)}"]
    for name, row in rows.items():
        cells = [cell if isinstance(cell, str) else f"{cell:.0e}" for cell in row]
        lines.append(f"| {' | '.join([name, *cells])} |")
    return lines


def _row(name: str, found: Table) -> str:
    ratios = " ".join(f"{value:.2f}" for value in found["effectivity"])
    cells = [
        name,
        found["requests"],
        found["accepted"],
        f"{found['met']} ({100.0 * found['met'] / found['accepted']:.1f} %)",
        found["false_refusals"],
        ratios,
        found["effectivity_within"],
        f"{found['cost_ratio_median']:.2f}",
        f"{found['all_in_ratio_median']:.2f}",
        f"{found['delivered_met']} ({100.0 * found['delivered_met'] / found['requests']:.1f} %)",
    ]
    return f"| {' | '.join(map(str, cells))} |"


def theories(found: Table) -> list[str]:
    """Return the table of the other theory."""
    rows = {n: [*s["theories"].values(), s["met"]] for n, s in found["scenes"].items()}
    return [
        "Differences of the two theories, of the largest value of each signal, and the accepted "
        "requests at 1e-1, 1e-2 and 1e-3 whose delivered result has the accuracy against beams in "
        "segments:",
        "",
        *_by_signal(rows, "met"),
    ]


if __name__ == "__main__":
    main()
