"""The one list of codes of findings: level, and the number that a finding is compared with.

docs/warnings.md says what each means, its threshold and what helps. Codes of packages, sections,
shells and blades are in these files; the preprocessor does not import this list: a contract test
compares codes and limits with its source.
"""

from math import isnan, nan
from typing import Any, Literal, NamedTuple, TypedDict

from ..package.common.plausible import ANGLE, MATERIAL, SIZE

# error: the results cannot be used, or end early; warning: they may be wrong; note: worth knowing.
Level = Literal["error", "warning", "note"]


OPTIONAL = ("level", "body", "t", "value", "limit")  # of a finding in summary.json


class Entry(TypedDict, total=False):
    """A finding in summary.json."""

    code: str
    message: str
    level: Level
    body: str
    t: float  # [s]
    value: float
    limit: float


class Finding(NamedTuple):
    """What was found, where and when, and how far it is beyond its limit.

    `value` and `limit` are in the unit of the code (docs/warnings.md).
    """

    code: str
    text: str  # what happened, what was expected, what helps
    body: str = ""  # name of the body or joint, empty if it concerns the whole run
    t: float | None = None  # [s]
    value: float | None = None
    limit: float | None = None
    level: Level = "warning"

    def entry(self) -> Entry:
        """Return the entry of summary.json; keys without a value are left out."""
        known: Any = {key: getattr(self, key) for key in OPTIONAL}
        known = {key: value for key, value in known.items() if value not in (None, "")}
        return {"code": self.code, "message": self.text, **known}

    @classmethod
    def of_entry(cls, entry: Entry) -> "Finding":
        """Return the finding of an entry of summary.json."""
        known: Any = {key: value for key, value in entry.items() if key in OPTIONAL}
        return cls(entry["code"], entry["message"], **known)


class Code(NamedTuple):
    """A kind of finding; docs/warnings.md has meaning, threshold and remedy.

    `why` says in plain words what ended a run.
    """

    name: str
    level: Level
    limit: float = nan
    why: str = ""

    def finding(
        self, text: str, *, body: str = "", t: float | None = None, value: float | None = None
    ) -> Finding:
        """Return a finding of this code.

        Parameters
        ----------
        text : what was found, and what helps
        body : name of the body
        t : time [s]
        value : number that is compared with the limit of the code
        """
        limit = None if isnan(self.limit) else self.limit
        return Finding(self.name, text, body, t, value, limit, self.level)


_RUNS: list[Code] = []


def _run(name: str, level: Level = "warning", limit: float = nan, why: str = "") -> Code:
    _RUNS.append(Code(name, level, limit, why))
    return _RUNS[-1]


def _of_files(*codes: str | tuple[str, float]) -> tuple[Code, ...]:
    """Warnings of files: names, some with a limit."""
    pairs = (code if isinstance(code, tuple) else (code, nan) for code in codes)
    return tuple(Code(name, "warning", limit) for name, limit in pairs)


# The end of a run.
RUN_FAILED = _run("run-failed", "error", why="the integrator could not go on")
RUN_INTERRUPTED = _run("run-interrupted", "error", why="interrupted")
BUDGET_USED = _run("budget-used-up", "error", why="the budget is used up")
UNDER_WAY = _run("run-under-way", "note")
# Start and constraints.
REDUNDANT = _run("redundant-constraints", "note")
SINGULAR_START = _run("singular-start")
START_MOVED = _run("start-moved", limit=1e-3)
LOADED_START = _run("loads-begin-suddenly", limit=0.05)
# solver/package/common/plausible.py has the limits with their sources.
MATERIAL_UNITS = _run(MATERIAL)
SIZE_UNITS = _run(SIZE)
ANGLE_UNITS = _run(ANGLE)
TABLE_OVERSHOOTS = _run("table-overshoots", "note", 0.05)
LOCKED = _run("mechanism-locked")
CONSTRAINT_DRIFT = _run("constraint-drift", limit=1e-6)
FEEDBACK = _run("feedback-limits-steps", "note", 0.06)
# Steps that are tiny beside what is asked of the run (integrators/generic/pace.py).
VIBRATION_DAMPED = _run("vibration-damped")
STALLED = _run("steps-tiny")
GROWS = _run("motion-grows", limit=10.0)
REFUSED = _run("steps-refused", "note", 0.2)
ORDER_TWO = _run("rtol-not-kept", limit=3e-8)
# solver/integrators/breakpoints.py has the limit.
BREAKS_UNSEARCHED = _run("breaks-not-searched", limit=50000.0)
CHATTERS = _run("law-chatters")
# Singular positions on the way.
SINGULAR = _run("singular-position", "error", why="a singular position")
BRANCH = _run("branch-change", "error", why="motion on another branch")
SINGULAR_PASSED = _run("singular-passed", "note")
# Balances.
ENERGY_DRIFT = _run("energy-drift", limit=1e-3)
ENERGY_JUMP = _run("energy-jump", limit=1e-3)
MOMENTUM = _run("momentum-balance", limit=1e-8)
# Elastic motion.
SPIN = _run(
    "spin-above-clamped-frequency",
    "error",
    why="linear bodies have no stiffness left at that speed",
)
ROTATION = _run("elastic-rotation-large", limit=0.1)
FEW_MODES = _run("modes-too-few", limit=0.1)
CUT_EARLY = _run("modes-cut-early", limit=0.02)
MATTERS = _run("stiffening-matters", limit=0.05)
TILTING = _run("sections-tilt", limit=2e-3)
BUCKLING = _run("buckling-by-motion", "error", 0.0, why="the motion buckles a body")
BUCKLING_LOAD = _run("buckling-load", "error", why="loads buckle a linear body")
UNDISTURBED = _run("unstable-undisturbed", limit=6.9)
INDEFINITE = _run(
    "stiffened-mass-indefinite", "error", -1e-12, why="a stiffened body is too far from its frame"
)
NO_STIFFENING_DATA = _run("stiffening-without-data")
WITH_DATA = (
    "Beams of up to 40 modes have them since format 1.3 of the package, shells and solids with "
    "second_order = true: build it again. Imported bodies and measured modes have none"
)
PLY_FAILURE = _run("ply-failure", limit=1.0)
PLAN_TOO_COARSE = Code("plan-too-coarse", "warning")
INPUT = Code("input", "error")
PACKAGE = Code("package", "error")
WORKER_LOST = Code("worker-lost", "error")
DEFECT = Code("defect", "error")

RUN_CODES = tuple(_RUNS)
MEMBER_CODES = (PLAN_TOO_COARSE, INPUT, PACKAGE, WORKER_LOST, DEFECT)
BODY_CODES = _of_files(
    "package-doubtful",
    ("mesh-coarse-for-modes", 0.01),
    ("static-modes-dependent", 1e-6),
    ("measured-shape-rigid", 0.1),
    ("measured-modal-mass", 0.1),
    ("measured-shapes-coupled", 0.1),
    "interface-without-rotation",
    ("modes-not-counted", 400_000.0),
    ("solid-mesh-coarse", 0.05),
)
SHELL_CODES = _of_files(
    ("sliver", 0.05),
    ("nodes-not-merged", 1e-7),
    "several-parts",
    "normals-disagree",
    ("triangles-not-paired", 0.25),
    ("link-distorts-section", 0.1),
    ("cst-in-plane-bending", 4.0),
    ("dst-thick", 0.1),
    "drilling-fictitious-flat",
    "zero-energy-modes",
    ("shell-triangles-warped", 0.1),
    ("shell-quadrilaterals-warped", 0.1),
    ("shell-mesh-coarse", 0.05),
    ("buckling-after-large-rotation", 0.1),
    ("buckles-in-plane", 0.1),
    "few-digits",
    ("laminate-unsymmetric", 1e-6),
    ("laminate-unbalanced", 1e-6),
    ("laminate-soft-core", 0.3),
)
SECTION_CODES = _of_files(
    ("unmerged-nodes", 1e-7),
    ("sliver-elements", 0.04),
    "cells-overlap",
    "plies-not-resolved",
    "degree-1-locks",
    ("nearly-incompressible", 5e3),
    ("ill-conditioned", 1e14),
    ("stress-at-corner", 195.0),
    ("coarse-mesh", 0.05),
    "model-not-computed",
    "no-density",
    ("direction-reverses", 1e-3),
    ("strongly-curved", 0.5),
    ("taper-neglected", 1e-3),
    ("verification-differs", 1e-6),
    ("accuracy-not-met", 4e5),
)
BLADE_CODES = _of_files(
    "not-modelled",
    "unlike-a-blade",
    ("rule-differs", 0.01),
    ("no-room", 0.02),
    ("differs-from-file", 0.1),
)
GROUPS = {
    "Runs": RUN_CODES,
    "Members of a sweep without a result": MEMBER_CODES,
    "Bodies": BODY_CODES,
    "Shells and laminates": SHELL_CODES,
    "Cross-sections": SECTION_CODES,
    "Blades": BLADE_CODES,
}
CODES = {code.name: code for group in GROUPS.values() for code in group}
