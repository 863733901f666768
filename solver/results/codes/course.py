"""Codes of the start, the course and the end of a run."""

from ...package.common.plausible import MATERIAL, SIZE
from ..finding import Code

# The end of a run.
RUN_FAILED = Code(
    "run-failed",
    "error",
    "the integrator could not continue; the results up to there are kept",
    "the step became too short, or a number was not finite",
    "look for a jump or singularity in the forces just after the end; change tolerances or the "
    "integrator as the message says",
)
RUN_INTERRUPTED = Code(
    "run-interrupted",
    "error",
    "the user interrupted the run (Ctrl-C); the results up to there are kept",
    "none",
    "start the run again",
)

# Start and constraints.
REDUNDANT = Code(
    "redundant-constraints",
    "note",
    "some constraint equations follow from the others: the motion is determined, the share of "
    "these joints in the reactions is not",
    "rank of the scaled constraint Jacobian below its number of rows",
    "use joints that leave more freedom (spherical, universal, cylindrical)",
)
SINGULAR_START = Code(
    "singular-start",
    "warning",
    "the mechanism starts in a singular position, where it can move in more directions than "
    "elsewhere",
    "the rank of the constraint Jacobian is lower than in a position nearby",
    "start elsewhere, or give velocities that say in which direction it moves",
)
START_MOVED = Code(
    "start-moved",
    "warning",
    "joints do not close where the case places the bodies: these were moved or turned at the start",
    "distance above {limit:g} of the size of the mechanism, or angle above {limit:g} rad, without "
    "what drives prescribe at t = 0; bodies at the origin by default may move",
    "give the position and rotation_deg that the finding lists; check lengths, ground points and "
    "axes if the start is another than meant",
    limit=1e-3,
)
LOADED_START = Code(
    "loads-begin-suddenly",
    "warning",
    "a body starts in another shape than weight, springs, drives and inertia at t = 0 call for: it "
    "vibrates from the start, and reactions are up to twice those of a gentle start",
    "strain energy of the difference of the shapes above {limit:g} of the largest of the run",
    '`start = "quasi-static"`; `start = "equilibrium"`, with `spin` if it turns; drives that begin '
    "without acceleration (`smooth_step`, `ramp`); none if a sudden release is meant",
    limit=0.05,
)
# solver/package/common/plausible.py has the limits with their sources.
MATERIAL_UNITS = Code(
    MATERIAL,
    "warning",
    "the constants of a material do not fit together: they may be in other units than Pa and kg/m3",
    "sqrt(E / rho) below 20 or above 50 000 m/s, density outside 3 to 23 000 kg/m3, a modulus or "
    "strength below 1e-7 of the largest modulus; gels are slower. Materials of less than 0.001 of "
    "the stiffness and density of others (voids), those with a density of 1 (examples without "
    "units) and sections of other codes' files are not judged",
    "correct the numbers: 70 GPa is 70e9, 1.6 g/cm3 is 1600. If they are meant: "
    '`allow = ["material-units"]` at the top of the case, section or shell',
)
SIZE_UNITS = Code(
    SIZE,
    "warning",
    "a size or mass is unusual: lengths may be in mm, or an inertia in kg mm2",
    "beam wider than long, shell thicker than its shorter side, plies of fibres outside 1e-6 to "
    "0.1 m, sections outside 1e-7 to 50 m or above 5e4 kg/m, bodies above 1e8 kg or of less than "
    "1e-4 kg/m3 (mass over the cube of twice the radius of gyration)",
    "correct the numbers, or give a mesh in mm `scale = 1e-3`. If they are meant: "
    '`allow = ["size-units"]` at the top of the case, section or shell',
)
TABLE_OVERSHOOTS = Code(
    "table-overshoots",
    "note",
    "the cubic spline through the points of a table goes far beyond their values",
    "excess above {limit:g} of the range of the values",
    '`interpolation = "linear"` or `"pchip"`; more points',
    limit=0.05,
)
LOCKED = Code(
    "mechanism-locked",
    "warning",
    "the joints leave no degree of freedom at the start",
    "no degree of freedom at t = 0",
    "use flexible bodies, or joints that leave more freedom",
)
CONSTRAINT_DRIFT = Code(
    "constraint-drift",
    "warning",
    "joined points move apart",
    "distance of joined points above {limit:g} m",
    'decrease `rtol`, or set `constraints = "projection"`',
    limit=1e-6,
)
FEEDBACK = Code(
    "feedback-limits-steps",
    "note",
    "the feedback of the constraints (Baumgarte, augmented Lagrangian), not the motion, keeps the "
    "steps short",
    "feedback rate times mean step, over the order of the method, above {limit:g}",
    'reduce `alpha` and `beta` (`frequency`), or set `constraints = "projection"`',
    limit=0.06,
)

# Steps that are tiny beside what is asked of the run (integrators/generic/advice.py).
VIBRATION_DAMPED = Code(
    "vibration-damped",
    "warning",
    "a vibration that was resolved kept the steps tiny: from then on `radau` damps all vibrations "
    "above a cutoff frequency, which the finding gives with the energy that they lost",
    "on average more than 100 steps for each `output_step` (or each thousandth of the run, if that "
    "is shorter), over 2000 attempts; limits of the cutoff: pi / `output_step` to ten times that, "
    "and above it less than half of the kinetic energy",
    "`cutoff_frequency = 0` if the vibration matters; else damping of the body or element, or a "
    "cutoff of your own",
)
STALLED = Code(
    "steps-tiny",
    "warning",
    "a motion that may be of no interest keeps the steps tiny, and nothing was done about it: the "
    "run takes long",
    "as `vibration-damped`",
    '`integrator = "radau"` without `cutoff_frequency = 0`, fewer modes, or damping of the body or '
    "element",
)

GROWS = Code(
    "motion-grows",
    "warning",
    "the motion grows exponentially up to the end of the run, far beyond what gravity, drives and "
    "loads of the start can give: a feedback is unstable",
    "kinetic energy above {limit:g} times that of the mechanism at its speed (docs/accuracy.md), "
    "and its peaks in the last five tenths of the run each three times the one before",
    "smaller gains, a shorter `sample_time`, a sensor at the actuator; `plymotion modes` shows the "
    "unstable mode of a continuous controller",
    limit=10.0,
)

REFUSED = Code(
    "steps-refused",
    "note",
    "many attempts at a step were refused: each cost as much as a step. The finding gives the "
    "reasons, and the body and mode that caused most of them",
    "share of refused attempts above {limit:g}, in runs of at least 100 attempts, where a shorter "
    "longest step or another force would need fewer",
    "`max_step` of 1.25 average steps; if a vibration of no interest is the reason, "
    "`cutoff_frequency` or damping",
    limit=0.2,
)

# Singular positions on the way.
SINGULAR = Code(
    "singular-position",
    "error",
    "the mechanism reaches a position in which its constraints lose rank, and the treatment of "
    "the constraints cannot pass it",
    "smallest singular value of the scaled Jacobian below 0.001 of its largest value in the run",
    'set `constraints = "projection"`, or `"ggl"` with `integrator = "generalized-alpha"`',
)
BRANCH = Code(
    "branch-change",
    "error",
    "the run left a singular position on another branch of motion, or with an impact: what "
    "follows is not the motion of the mechanism",
    "velocity turned by more than 0.2, or energy balance changed by more than 0.001 of the energy "
    "in play, within the neighbourhood of the position",
    "decrease `rtol`; check lengths that nearly fit",
)
SINGULAR_PASSED = Code(
    "singular-passed",
    "note",
    "the run passed singular positions with continuous velocity and energy",
    "as `singular-position`",
    "none needed; check that the mechanism is meant to continue in this direction",
)

CODES = (
    RUN_FAILED,
    RUN_INTERRUPTED,
    REDUNDANT,
    SINGULAR_START,
    START_MOVED,
    LOADED_START,
    MATERIAL_UNITS,
    SIZE_UNITS,
    TABLE_OVERSHOOTS,
    LOCKED,
    CONSTRAINT_DRIFT,
    FEEDBACK,
    VIBRATION_DAMPED,
    STALLED,
    GROWS,
    REFUSED,
    SINGULAR,
    BRANCH,
    SINGULAR_PASSED,
)
