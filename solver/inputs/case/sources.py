"""The sources of the solver, whose change makes what was computed with them out of date."""

from ...math.digests import sources_sha256

# Parts of solver/ that have no part in the motion of a mechanism.
_APART = (
    "solver/__main__.py",
    "solver/commands/",
    "solver/extras/",
    "solver/report/",
    "solver/workers/",
)


def solver_sha256() -> str:
    """Return the digest of the sources of the solver."""
    return sources_sha256("solver", apart=_APART)
