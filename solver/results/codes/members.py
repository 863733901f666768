"""Codes of members of a sweep that have no result."""

from ..finding import Code

INPUT = Code(
    "input",
    "error",
    "a member of a sweep cannot be prepared: its numbers do not make a mechanism",
    "none",
    "correct the values named in the message",
)
PACKAGE = Code(
    "package",
    "error",
    "the modal package of a member of a sweep cannot be read, or was built from other inputs",
    "none",
    "run `plymotion packages` with the sweep file",
)
WORKER_LOST = Code(
    "worker-lost",
    "error",
    "the process that computed a member of a sweep ended without a result",
    "none",
    "reduce `--jobs` if memory ran out",
)
DEFECT = Code(
    "defect",
    "error",
    "a member of a sweep ended in an error of the program",
    "none",
    "report it with the traceback",
)

PLAN_TOO_COARSE = Code(
    "plan-too-coarse",
    "warning",
    "the plan of a sweep with `[fidelity]`, made at its base, does not reach the accuracy there or "
    "at a member that was drawn to check it",
    "estimated error above 0.9 of `accuracy`",
    "ask for less (a larger `accuracy`), allow a larger `budget`, divide the sweep, or edit its "
    "`.plan.toml`",
)

CODES = (
    PLAN_TOO_COARSE,
    INPUT,
    PACKAGE,
    WORKER_LOST,
    DEFECT,
)
