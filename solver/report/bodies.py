"""Sections of report.html on bodies: modes, masses, strength of plies, fatigue."""

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..results.run_result import BodyView
from .report_data import Story
from .sections import Cell, Row, figures, name_of, section, table
from .table import number

# The sections of report.html on the modes of the bodies and their masses.

ROUND_OFF = 1e-6  # per cent


def modes_section(stories: list[Story]) -> str:
    """Return frequency and share of the strain energy of every mode, or nothing without modes."""
    head = ["run", "body", "mode", "frequency [Hz]", "share of strain energy [%]"]
    head += ["largest coordinate [-]", "view"]
    rows: list[Row] = []
    for story in stories:
        for i, body in enumerate(story.result.bodies):
            if body.view is None or not len(body.view.shapes_B):
                continue
            q = modal_coordinates(story, body.view)
            shares, largest = energy_shares(body.view, q), np.abs(q).max(axis=0)
            for k, label in enumerate(body.view.labels):
                rows.append(
                    [
                        name_of(story),
                        escape(body.name),
                        Cell(f"{k + 1}: {escape(label)}", k),
                        figures(float(body.view.frequencies[k]) / (2.0 * np.pi), 5),
                        _share(100.0 * float(shares[k])),
                        figures(float(largest[k]), 3),
                        f"<button type='button' class='small' data-run='{escape(story.name)}' "
                        f"data-solo='{i},{k}' aria-label='show mode {k + 1} of "
                        f"{escape(body.name)} alone'>alone</button>",
                    ]
                )
    if not rows:
        return ""
    tables = [table("Modes of the bodies", head, rows), _damping(stories)]
    return section("modes", "Modes", *tables)


def _damping(stories: list[Story]) -> str:
    """Return the damping of the lowest vibration of each damped body in the mechanism."""
    head = ["run", "body", "in the mechanism [Hz]", "damping ratio [%]"]
    head += ["by itself [Hz]", "damping ratio [%]"]
    rows: list[Row] = [
        [
            name_of(story),
            escape(entry["body"]),
            figures(entry["frequency_hz"], 4),
            figures(100.0 * entry["damping_ratio"], 2),
            figures(entry["own_frequency_hz"], 4),
            figures(100.0 * entry["own_damping_ratio"], 2),
        ]
        for story in stories
        for entry in story.summary.get("damping", ())
    ]
    title = "Damping of the lowest vibration of each body"
    return f"<h3>{title}</h3>{table(title, head, rows)}" if rows else ""


def _share(percent: float) -> Cell:
    """Return a share; what is round-off only is 0."""
    return figures(percent if abs(percent) > ROUND_OFF else 0.0, 3)


def modal_coordinates(story: Story, view: BodyView) -> Array:
    """Modal coordinates of a body at all output times, (k, m)."""
    first = view.first_position + 7
    return np.asarray(story.result.q[:, first : first + len(view.shapes_B)])


def energy_shares(view: BodyView, q: Array) -> Array:
    """Share (m,) of each mode of the strain energy, mean over all output times [-].

    The energy 1/2 q' K q is assigned to the modes as 1/2 q_i (K q)_i; they add up to 1.
    """
    each = np.einsum("ki,ki->i", q, q @ view.stiffness)
    total = float(each.sum())
    return np.asarray(each / total if total else np.zeros(len(each)))


def masses_section(stories: list[Story]) -> str:
    """Return masses and mass centres of the bodies, or nothing if the results have none."""
    head = ["run", "body", "mass [kg]", "centre x [m]", "centre y [m]", "centre z [m]"]
    head += ["modes", "package inputs"]
    rows: list[Row] = []
    for story in stories:
        for body in story.result.bodies:
            view = body.view
            if view is None:
                continue
            digest = str(view.provenance.get("inputs_sha256", ""))[:12]
            rows.append(
                [
                    name_of(story),
                    escape(body.name),
                    figures(view.mass, 5),
                    *(figures(float(x), 4) for x in _without_round_off(view.centre_B)),
                    Cell(str(len(view.shapes_B)), len(view.shapes_B)),
                    f"<code>{escape(digest)}</code>" if digest else "-",
                ]
            )
    if not rows:
        return ""
    return section("masses", "Masses", table("Masses, centres in body axes", head, rows))


def _without_round_off(centre_B: Array) -> Array:
    """Coordinates with zeros in place of what is small against the others."""
    largest = float(np.abs(centre_B).max())
    return np.where(np.abs(centre_B) > 1e-12 * largest, centre_B, 0.0)


# The sections of report.html on the strength of plies and on fatigue.

PLIES_SHOWN = 5  # of each body
HEAD = ["run", "body", "strength ratio R [-]", "margin R - 1 [-]", "criterion", "mode"]
HEAD += ["x [m]", "time [s]", "ply", "place"]


def strength_section(stories: list[Story]) -> str:
    """Return the section on ply stresses, or nothing if no material has strengths."""
    judged = [story for story in stories if story.summary.get("strength")]
    if not judged:
        return ""
    bodies = [
        (s, body, strength) for s in judged for body, strength in s.summary["strength"].items()
    ]
    weakest = [
        (story, body, strength)
        for story, body, whole in bodies
        for strength in whole.get("plies", [])[:PLIES_SHOWN]
    ]
    tables = table("Lowest strength ratio of each body", HEAD, _rows(bodies))
    if len(weakest) > len(bodies):
        tables += "<h3>Weakest plies of each body</h3>"
        tables += table("Weakest plies of each body", HEAD, _rows(weakest))
    return section("strength", "Strength", tables)


def _rows(strengths: list[tuple[Story, str, dict[str, Any]]]) -> list[Row]:
    """Return rows of lowest strength ratios: story, body, entry of summary.json."""
    rows: list[Row] = []
    for story, body, entry in strengths:
        ratio = number(entry["ratio"], 4)
        shown = f"<span class='badge bad'>{ratio}</span>" if fails(entry) else ratio
        rows.append(
            [
                name_of(story),
                escape(body),
                Cell(shown, entry["ratio"]),
                figures(entry["margin"]),
                escape(entry["criterion"]),
                escape(entry["mode"]),
                figures(entry["x"], 4),
                figures(entry["time"], 4),
                escape(_ply(entry["ply"])),
                _jump(story, body, entry),
            ]
        )
    return rows


def _jump(story: Story, body: str, entry: dict[str, Any]) -> str:
    """Return a button that shows the place of a ply at its time in the view."""
    if entry["time"] is None:
        return ""
    node = place(story, body, entry)
    at = "" if node is None else f" data-node='{node}'"
    return (
        f"<button type='button' class='small' data-run='{escape(story.name)}' "
        f"data-body='{escape(body)}' data-time='{float(entry['time'])!r}'{at} "
        f"data-text='{escape(ply_text(entry))}'>show</button>"
    )


def worst(story: Story) -> list[dict[str, object]]:
    """Return body, node, time and text of the weakest ply of each body, the weakest first."""
    weakest = sorted(
        (
            (entry["ratio"], body, entry)
            for body, entry in story.summary.get("strength", {}).items()
            if entry["ratio"] is not None and entry["time"] is not None
        ),
        key=lambda each: each[0],
    )
    return [
        {
            "body": body,
            "node": place(story, body, entry),
            "time": entry["time"],
            "text": ply_text(entry),
        }
        for _, body, entry in weakest
    ]


def ply_text(entry: dict[str, Any]) -> str:
    """Return ply, criterion and ratio of an entry in words."""
    return f"R = {number(entry['ratio'], 4)} ({entry['criterion']}), {_ply(entry['ply'])}"


def _ply(ply: Mapping[str, object]) -> str:
    """Return a ply in words; a solid has a surface in place of plies."""
    region, material = ply["region"], ply["material"]
    if region == f"surface {material}":
        return str(region)
    return f"{region} ply {ply['index']}, {material}, {ply['angle_deg']:g} deg"


def place(story: Story, body: str, entry: dict[str, Any]) -> int | None:
    """Return the drawn node nearest to the place of an entry; None if the body is not drawn.

    Parameters
    ----------
    story : a run, with results and summary
    body : name of the body
    entry : entry of summary.json with the place
    """
    for geometry in story.result.bodies:
        if geometry.name != body or geometry.view is None or geometry.view.sites is None:
            continue
        at = geometry.view.sites.place_B
        if len(entry["point"]) == 3:
            target = np.asarray(entry["point"], dtype=float)
        else:
            x = np.asarray(story.summary["strength"][body]["along_beam"]["x"], dtype=float)
            if len(x) != len(at):
                return None
            target = at[int(np.argmin(np.abs(x - entry["x"])))]
        return int(np.argmin(np.linalg.norm(geometry.nodes_B - target, axis=1)))
    return None


def fails(entry: dict[str, Any]) -> bool:
    """True if a ply of a body fails, from its entry in summary.json."""
    return entry["ratio"] is not None and entry["ratio"] < 1.0


def fatigue_section(stories: list[Story]) -> str:
    """Return the section on Miner sums, or nothing if no stress has an S-N line."""
    head = ["run", "stress", "Miner sum of the run [-]", "runs to failure [-]"]
    head += ["cycles", "largest range [Pa]"]
    rows: list[Row] = [
        [
            name_of(story),
            escape(signal),
            figures(entry["damage"], 4),
            figures(entry["repetitions"], 4),
            figures(entry["cycles"], 6),
            figures(entry["largest_range"], 4),
        ]
        for story in stories
        for signal, entry in story.summary.get("fatigue", {}).items()
    ]
    if not rows:
        return ""
    return section("fatigue", "Fatigue", table("Miner sums", head, rows))
