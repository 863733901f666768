"""Verdicts, charts and pages of the arena: index.html and the tables of docs/arena.md."""

import html
import math
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import stability
from shell_text import replace_between
from solver_curves import front
from solver_text import machine

from plymotion.solver.report.style import Canvas, colour, house_style

OURS = "Plymotion"
DECADES = [10.0**-k for k in range(1, 13)]
EXUDYN_FROM = 1e-3  # the promise beside Exudyn holds below this error
MARKERS = ("o", "s", "D", "^", "v", "P", "X")
Rows = list[dict[str, Any]]


LEAST = 1e-3  # [s]: the resolution of CPU times


def cheapest(rows: Rows, target: float, key: str) -> dict[str, float]:
    """Least seconds of each code with an error below the target."""
    found: dict[str, float] = {}
    for row in rows:
        if not row["failed"] and row["error"] <= target and row[key] is not None:
            found[row["code"]] = min(found.get(row["code"], math.inf), max(row[key], LEAST))
    return found


def verdicts(rows: Rows, bars: dict[str, float]) -> dict[str, Any]:
    """Won and lost decades of error by scene, for whole processes and for solutions.

    A decade counts where its error is at least twice the bar of the truth and a code reaches it.
    """
    won: dict[str, list[str]] = {}
    lost: dict[str, list[str]] = {}
    margins: list[dict[str, Any]] = []
    beside = {}
    for scene, bar in bars.items():
        own = [row for row in rows if row["scene"] == scene]
        able = {r["code"] for r in own if not r["failed"]}
        if OURS not in able or len(able) < 2:
            continue
        for target in DECADES:
            if target < 2.0 * bar:
                break
            for key in ("process_s", "solution_s"):
                best = cheapest(own, target, key)
                timed = any(row["code"] == OURS and row[key] is not None for row in own)
                if not timed or not best or (len(best) == 1 and OURS not in best):
                    continue
                others = {c: s for c, s in best.items() if c != OURS}
                mine = best.get(OURS, math.inf)
                rival = min(others, key=lambda c: others[c]) if others else ""
                factor = mine / others[rival] if others else 0.0
                side = won if factor <= 1.0 else lost
                side.setdefault(f"{scene}, {key[:-2]}", []).append(f"{target:.0e}")
                margins.append(
                    {
                        "scene": scene,
                        "target": target,
                        "time": key[:-2],
                        "ours": mine,
                        "rival": rival,
                        "factor": factor,
                    }
                )
                if key == "process_s" and target < EXUDYN_FROM and "Exudyn" in best:
                    beside[scene] = beside.get(scene, True) and mine <= best["Exudyn"]
                elif key == "process_s" and target < EXUDYN_FROM and "Exudyn" in able:
                    beside.setdefault(scene, True)
    return {"won": won, "lost": lost, "margins": margins, "whole_process_at_most_exudyn": beside}


def charts(results: dict[str, Any], folder: Path) -> dict[str, str]:
    """Error against whole process and solution, one picture for each scene."""
    found = {}
    by_scene: dict[str, Rows] = defaultdict(list)
    for row in results["trials"]:
        if not row["failed"]:
            by_scene[row["scene"]].append(row)
    codes = sorted({row["code"] for row in results["trials"]})
    with house_style(formulas=True):
        for scene, rows in by_scene.items():
            canvas = Canvas(9.0, 3.6)
            bar, unit = results["truths"][scene], results["about"][scene].get("unit", "m")
            for axis, key in zip(canvas.panels(1, 2), ("process_s", "solution_s"), strict=True):
                methods = sorted({(r["code"], r["setting"]["method"]) for r in rows})
                for code, method in methods:
                    chosen = [
                        r for r in rows if (r["code"], r["setting"]["method"]) == (code, method)
                    ]
                    points = [(max(r["error"], bar, 1e-16), r[key]) for r in chosen if r[key]]
                    if not points:
                        continue
                    line = front(points)
                    k = codes.index(code)
                    of_code = [m for c, m in methods if c == code]
                    axis.plot(
                        [s for _, s in line],
                        [e for e, _ in line],
                        color=colour(k),
                        marker=MARKERS[of_code.index(method) % len(MARKERS)],
                        markersize=4,
                        label=f"{code}, {method}",
                    )
                axis.axhline(bar, color="#777777", linewidth=0.8, linestyle=":")
                words = "whole process" if key == "process_s" else "solution alone"
                axis.set(xscale="log", yscale="log", xlabel=f"CPU seconds, {words}")
                axis.set_ylabel(f"largest error [{unit}]")
            handles, labels = axis.get_legend_handles_labels()
            canvas.figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=7)
            name = f"{scene}.svg"
            canvas.save(folder / name)
            found[scene] = name
    return found


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table in Markdown."""
    return ["| " + " | ".join(r) + " |" for r in (head, ["---"] * len(head), *rows)]


def best_rows(results: dict[str, Any], codes: list[str]) -> list[list[str]]:
    """For each scene and a few errors: the least CPU seconds of every code, whole | solution."""
    found = []
    for scene, bar in results["truths"].items():
        own = [r for r in results["trials"] if r["scene"] == scene]
        reached = [r["error"] for r in own if not r["failed"]]
        if not reached or OURS not in {r["code"] for r in own}:
            continue
        targets = [t for t in DECADES if t >= max(2.0 * bar, min(reached))]
        for target in targets[1::2] or targets[-1:]:
            cells = []
            for code in codes:
                whole = cheapest(own, target, "process_s").get(code)
                alone = cheapest(own, target, "solution_s").get(code)
                cells.append(
                    "–"
                    if whole is None
                    else f"{whole:.2f}"
                    + (f", {alone:.2g}" if alone and math.isfinite(alone) else "")
                )
            found.append([scene, f"{target:.0e}", *cells])
    return found


def truth_rows(results: dict[str, Any]) -> list[list[str]]:
    """Truths with their bars."""
    return [
        [s, f"{t['bar']:.1e}", t["by"] + (" DISAGREE" if t["disagree"] else "")]
        for s, t in results["truth_by"].items()
    ]


def lost_rows(results: dict[str, Any]) -> list[list[str]]:
    """The largest factors of each scene and kind of time, worst first."""
    worst: dict[tuple[str, str], dict[str, Any]] = {}
    for m in results["margins"]:
        key = (m["scene"], m["time"])
        if m["factor"] > 1.0 and m["factor"] > worst.get(key, {"factor": 0.0})["factor"]:
            worst[key] = m
    ordered = sorted(worst.values(), key=lambda m: -m["factor"])
    return [
        [
            m["scene"],
            m["time"],
            f"{m['target']:.0e}",
            m["rival"],
            "not reached" if math.isinf(m["factor"]) else f"{m['factor']:.2g}",
        ]
        for m in ordered
    ]


def spent(results: dict[str, Any]) -> str:
    """How processes were run, and the CPU seconds of all."""
    if not (settings := results.get("settings")):
        return ""
    cpu, of_code = results.get("cpu_s", {}), Counter[str]()
    for row in results["trials"]:
        ended = settings["longest"] if row["failed"].startswith("more than") else 0.0
        of_code[row["code"]] += row["process_s"] or ended
    codes, parts = (", ".join(f"{k} {s:.0f}" for k, s in of.items()) for of in (of_code, cpu))
    return (
        "Processes have an environment of their own (one thread, bytecode kept). The first setting "
        "of a code in a scene runs twice, and the second run counts. A process of more than "
        f"{settings['longest']:g} CPU seconds is ended (`--longest`); of the settings of a method "
        f"one in {settings['thin']} is used (`--thin`); {settings['lanes']} processes run at a "
        f"time. CPU seconds: {parts}, in all {sum(cpu.values()):.0f}; of timed processes: {codes}."
    )


def summary(results: dict[str, Any]) -> list[str]:
    """The tables, in Markdown."""
    codes = sorted({row["code"] for row in results["trials"]}, key=lambda c: (c != OURS, c))
    beside = results["whole_process_at_most_exudyn"]
    good = sum(beside.values())
    count = {side: sum(map(len, results[side].values())) for side in ("won", "lost")}
    cannot = [
        [scene, code, why]
        for scene, of in results["cannot"].items()
        for code, why in of.items()
        if not why.startswith("a ")  # a code for other things
    ]
    measured = {row["scene"] for row in results["trials"] if row["code"] == OURS}
    missing = [scene for scene in results["truths"] if scene not in measured]
    failed: dict[tuple[str, str, str], str] = {}
    for r in results["trials"]:
        if r["failed"]:
            failed.setdefault((r["scene"], r["code"], r["setting"]["method"]), r["failed"])
    lines = [
        f"{results['scenes']} scenes; {', '.join(results['codes'])}. Decades of error: "
        f"{count['won']} won, {count['lost']} lost. Whole process at most Exudyn's at every decade "
        f"below 1e-3: {good} of {len(beside)} scenes that both can do.",
        "",
        *(spent(results), ""),
        *([f"Not measured in this run: {', '.join(missing)}.", ""] if missing else []),
        "Least CPU seconds with an error below the second column: whole process, solution alone.",
        "",
        *table(["scene", "error", *codes], best_rows(results, codes)),
        "",
        "### Where ours loses",
        "",
        *table(["scene", "time", "error", "best code", "ours / best"], lost_rows(results)),
        "",
        "### Truths",
        "",
        *table(["scene", "bar", "by"], truth_rows(results)),
        "",
        "### Who cannot",
        "",
        *table(["scene", "code", "reason"], cannot),
        "",
    ]
    if failed:
        told = [[*key, text.replace("|", "/")[:90]] for key, text in failed.items()]
        lines += [
            "### Runs that failed",
            "",
            *table(["scene", "code", "method", "first"], told),
            "",
        ]
    if results.get("error_bars"):
        inside, width = results["coverage"], results["bar_over_error_median"]
        told = f"Of the draws that were never used: {inside:.0%} of the true errors are inside, "
        told += f"bars are {width:.2g} times the error in the median."
        lines += ["### Error bars", "", *results["error_bars"], "", told, ""]
    if "stability" in results:
        lines += [
            "### Stability",
            "",
            "Of 117 runs with fixed steps (stiffness 1e2 to 1e10 N/m, steps 1e-4 to 0.1 s), those "
            "that are stable, grow, or stop:",
            "",
            *table(["code", "method", "stable", "grow", "stop"], stability.rows(results)),
            "",
        ]
    return [*lines, machine(None)]


def write(results: dict[str, Any], folder: Path) -> None:
    """index.html with charts."""
    pictures = charts(results, folder)
    parts = []
    lines = summary(results)
    k = 0
    while k < len(lines):
        if lines[k].startswith("|"):
            rows = []
            while k < len(lines) and lines[k].startswith("|"):
                rows.append([c.strip() for c in lines[k].strip("|").split(" | ")])
                k += 1
            cells = [
                "<tr>" + "".join(f"<{t}>{html.escape(c)}</{t}>" for c in r) + "</tr>"
                for t, r in zip(["th", "", *["td"] * len(rows)], rows, strict=False)
                if t
            ]
            parts.append(f"<table>{''.join(cells)}</table>")
            continue
        text = html.escape(lines[k].lstrip("# ").replace("`", ""))
        parts.append(f"<h2>{text}</h2>" if lines[k].startswith("#") else f"<p>{text}</p>")
        k += 1
    if "stability" in results:
        stability.draw(results["stability"], folder / "stability.svg")
        parts.append(
            "<h2>Map of stability</h2><p>Green: stable; orange: energy grows; red: stops. "
        )
        parts.append(
            "Dotted: step times rate is 2 where the rod hangs.</p>"
            '<img src="stability.svg" alt="map of stability">'
        )
    for scene, picture in pictures.items():
        about = results["about"][scene]
        parts.append(
            f'<h2 id="{scene}">{html.escape(about["title"])}</h2><p>{html.escape(about["source"])} '
            f"(licence {html.escape(about['licence'])}). {html.escape(about.get('note', ''))} "
            f"Truth: {html.escape(results['truth_by'][scene]['by'])}, "
            f'{results["truths"][scene]:.1e}.</p><img src="{picture}" alt="{scene}: error against '
            f'CPU seconds">'
        )
    style = (
        "body{font:15px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;"
        "color:#222}table{border-collapse:collapse;font-size:13px}td,th{border-bottom:1px solid "
        "#ddd;padding:2px 8px;text-align:left}td:nth-child(2){white-space:nowrap}"
        "img{max-width:100%}"
    )
    text = (
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>Arena</title>'
        f"<style>{style}</style><h1>Arena</h1>{''.join(parts)}</html>"
    )
    (folder / "index.html").write_text(text, encoding="utf-8")


def write_docs(results: dict[str, Any], path: Path) -> None:
    """Renew the tables of a page of docs."""
    replace_between(path, "arena", summary(results))
