"""The page of all findings, docs/warnings.md.

python -m plymotion.solver.results.codes.page > docs/warnings.md
"""

from ..finding import Code
from . import GROUPS

HEAD = """\
# Warnings

What a run, a package, a section or a shell may be warned of. This page is generated from
solver/results/codes/ by `make docs`.

Runs and members of sweeps are judged by the same checks. Findings are in `warnings` of
summary.json and in `members/warnings` of sweep.h5, on the screen and in the report. An entry of
summary.json has `code`, `message` and `level`, and where they are known `body`, `t` [s], `value`
and the `limit` that it is compared with. Levels: **error**, the results cannot be used or end
early; **warning**, they may be wrong; **note**, worth knowing.
"""

FOOT = {
    "Bodies": "In the provenance of the package, and repeated with every run of the body. "
    "Warnings of its section or shell come with them.",
    "Shells and laminates": "In the shell file, or in the package of a shell body.",
    "Cross-sections": "In the section file, and in the package of a beam with that section.",
    "Blades": "On the screen, by `plymotion blade` ([blade.md](blade.md)).",
}


def warnings_page() -> str:
    """Return the page."""
    parts = [HEAD]
    for title, codes in GROUPS.items():
        parts.append(f"## {title}\n")
        if title in FOOT:
            parts.append(f"{FOOT[title]}\n")
        parts.append("| code | level | meaning | threshold | remedy |\n|---|---|---|---|---|")
        parts.append("\n".join(_line(code) for code in codes) + "\n")
    return "\n".join(parts)


def _line(code: Code) -> str:
    threshold = code.threshold.format(limit=code.limit)
    cells = (f"`{code.name}`", code.level, code.meaning, threshold, code.remedy)
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    print(warnings_page(), end="")
