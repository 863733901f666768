"""The top of report.html: what became of each run, and every doubt about it."""

from html import escape
from typing import Any

from ..errors import counted
from ..results.verdict import invalid_words, verdict
from .elements import Cell, Row, figures, name_of, section, table
from .story import Story

_RANK = {"good": 0, "doubt": 1, "bad": 2}


def banner(stories: list[Story]) -> str:
    """Return one line on all runs, in the colour of the worst."""
    done = sum(not story.stopped for story in stories)
    worst = max((verdict(story.summary) for story in stories), key=lambda found: _RANK[found])
    words = [f"{done} of {counted(len(stories), 'run')} completed"]
    if invalid := sum(bool(invalid_words(story.summary)) for story in stories):
        words.append(f"{invalid} of them invalid")
    found = _said([each for story in stories for each in _doubts(story)])
    words.append(f"<a href='#doubts'>{found}</a>" if found else "no warnings")
    return f"<p class='verdict {worst}'>{', '.join(words)}.</p>"


def outcomes(stories: list[Story]) -> str:
    """Return the table of the runs."""
    head = ["run", "outcome", "constraint violation [m]", "energy drift [-]", "modes"]
    head += ["integrator", "steps", "rejected", "evaluations", "solve [s]", "preprocess [s]"]
    rows: list[Row] = []
    for story in stories:
        checks: dict[str, Any] = story.summary.get("checks", {})
        cost: dict[str, Any] = story.summary.get("cost", {})
        modes = ", ".join(f"{escape(b)} {n}" for b, n in checks.get("modes_used", {}).items())
        rows.append(
            [
                name_of(story),
                _outcome(story),
                figures(checks.get("constraint_position_max"), 2),
                figures(checks.get("energy_drift_relative"), 2),
                modes or "-",
                escape(str(cost.get("integrator", "-"))),
                *(_count(cost.get(key)) for key in ("steps", "rejected", "evaluations")),
                figures(cost.get("solve_s")),
                figures(cost.get("preprocess_s")),
            ]
        )
    return section("runs", "Runs", table("Outcome and cost of the runs", head, rows))


def doubts(stories: list[Story]) -> str:
    """Return all warnings and notes, by run."""
    items = []
    for story in stories:
        found = _findings(story)
        if not found:
            continue
        lines = "".join(_line(story, each) for each in found)
        anchor = f"warnings-{escape(story.name)}"
        items.append(f"<h3 id='{anchor}'>{escape(story.title)}</h3><ul>{lines}</ul>")
    return section("doubts", "Warnings and notes", "".join(items) or "<p>None.</p>")


def _line(story: Story, found: dict[str, Any]) -> str:
    level = str(found.get("level", "warning"))
    jump = ""
    if found.get("t") is not None:
        jump = (
            f" <button type='button' class='small' data-run='{escape(story.name)}' "
            f"data-time='{float(found['t'])!r}'>show</button>"
        )
    return (
        f"<li class='{escape(level)}'><code>{escape(found['code'])}</code> "
        f"{escape(found['message'])}{jump}</li>"
    )


def _findings(story: Story) -> list[dict[str, Any]]:
    return list(story.summary.get("warnings", []))


def _doubts(story: Story) -> list[dict[str, Any]]:
    return [found for found in _findings(story) if found.get("level", "warning") != "note"]


def _said(found: list[dict[str, Any]]) -> str:
    """Return how many errors and warnings there are; nothing if there is none."""
    errors = sum(each.get("level") == "error" for each in found)
    counts = {"error": errors, "warning": len(found) - errors}
    return ", ".join(counted(n, word) for word, n in counts.items() if n)


def _count(value: int | None) -> Cell:
    return Cell("-" if value is None else str(value), value)


def _outcome(story: Story) -> Cell:
    t_end = float(story.summary.get("t_end") or story.result.t[-1])
    kind, said = verdict(story.summary), _said(_doubts(story))
    words = f"stopped at {t_end:.4g} s" if story.stopped else f"completed, {t_end:.4g} s"
    words = invalid_words(story.summary) or words
    badge = f"<span class='badge {kind}'>{words}</span>"
    if said:
        badge += f"<br><a href='#warnings-{escape(story.name)}'>{said}</a>"
    return Cell(badge, float(_RANK[kind]))
