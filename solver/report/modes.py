"""The sections of report.html on the modes of the bodies and their masses."""

from html import escape

import numpy as np

from ..math.arrays import Array
from ..results.view import BodyView
from .elements import Cell, Row, figures, name_of, section, table
from .story import Story

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
    return table("Damping of the lowest vibration of each body", head, rows) if rows else ""


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
