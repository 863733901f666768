"""Codes of what is checked in the results of a run: balances, elastic motion, strength."""

from ..finding import Code

# Balances.
ENERGY_DRIFT = Code(
    "energy-drift",
    "warning",
    "energy less the work of drives, loads and dampers changes during the run",
    "change above {limit:g} of the energy in play: the largest of kinetic and strain energy, "
    "change of potential and work at any step; at least that of 1000 rtol times the speed of the "
    "mechanism",
    "decrease `rtol`",
    limit=1e-3,
)
ENERGY_JUMP = Code(
    "energy-jump",
    "warning",
    "a single step changes the energy balance visibly: an impact, a jump of a force, or a step "
    "that is too long",
    "change in one step above {limit:g} of the energy in play",
    "look for an impact or a jump of a force at the time given; decrease `rtol`, or set `max_step`",
    limit=1e-3,
)
MOMENTUM = Code(
    "momentum-balance",
    "warning",
    "loads and reactions do not add up to the change of momentum of some body",
    "difference above {limit:g} of the largest force or moment",
    "do not use the reactions; look for a position in which the equations of motion are nearly "
    "singular",
    limit=1e-8,
)

# Elastic motion.
SPIN = Code(
    "spin-above-clamped-frequency",
    "error",
    "a linear flexible body spins faster than its first natural frequency in its own frame: it "
    "has no stiffness left",
    "smallest eigenvalue of the stiffness, less what spinning takes away, not above 0",
    "set `geometric_stiffening = true`, use a stiffer or shorter body, or reduce the speed",
)
ROTATION = Code(
    "elastic-rotation-large",
    "warning",
    "an interface of a flexible body turns so far relative to the body frame that small "
    "rotations are a poor assumption",
    "rotation above {limit:g} rad",
    "use a chord or mean-axis frame, divide a beam by `segments`, or stiffen it",
    limit=0.1,
)
FEW_MODES = Code(
    "modes-too-few",
    "warning",
    "the highest vibration mode of a family (bending-xy, torsion, ...) carries a visible share of "
    "the strain energy of its body: the series of modes is cut too early; or the modes of a "
    "straight beam miss much of its static deformation under the loads of the run",
    "share above {limit:g} of the peak strain energy of the body: strain energy at the instant at "
    "which the family has most, or largest kinetic energy. With static modes (`attachment`) at all "
    "loaded places only the kinetic energy counts. Of one mode alone, what a second one would "
    "have. Static deformation: more than 10 % of its strain energy missing, by the equilibrium of "
    "the loads at every section",
    "use more modes of the family, or static modes where forces act",
    limit=0.02,
)
MATTERS = Code(
    "stiffening-matters",
    "warning",
    "the geometric stiffness of the loads is not small against the elastic stiffness of a linear "
    "body",
    "largest eigenvalue of K^-1 K_geo above {limit:g}",
    "set `geometric_stiffening = true`",
    limit=0.05,
)
BUCKLING = Code(
    "buckling-by-motion",
    "error",
    "a stiffened body loses all stiffness in one of its modes under the loads of the motion and "
    "the joints: it buckles",
    "smallest eigenvalue of elastic plus geometric stiffness not above {limit:g}, for longer than "
    "0.05 rad of the lowest vibration of the body; the run ends "
    'there unless `on_invalid = "warn"`',
    "split the body, stiffen it, or reduce the load",
    limit=0.0,
)
BUCKLING_LOAD = Code(
    "buckling-load",
    "error",
    "the loads of a linear body exceed its buckling load; the body keeps its full stiffness, "
    "so that its motion is wrong from then on",
    "as `buckling-by-motion`, with the geometric stiffness that the body would have",
    "set `geometric_stiffening = true`, split the body, stiffen it, or reduce the load",
)
INDEFINITE = Code(
    "stiffened-mass-indefinite",
    "error",
    "a stiffened body is so far from its frame that its mass matrix is not positive definite; a "
    "warning where joints hold the body in the directions concerned",
    "smallest eigenvalue of the mass matrix, scaled to a unit diagonal, not above {limit:g}, in "
    "the motions that joints leave free; or of the body alone, with an interface that has turned "
    "by more than 0.1 rad",
    "use a chord or mean-axis frame, or split the body",
    limit=-1e-12,
)
NO_STIFFENING_DATA = Code(
    "stiffening-without-data",
    "warning",
    "`geometric_stiffening` is set, but the package of a body has no second-order data: the body "
    "stays linear",
    "no group `second_order` in the package",
    "build the package again; beams of up to 40 modes have the data, and shells with "
    "`second_order = true`",
)
PLY_FAILURE = Code(
    "ply-failure",
    "warning",
    "a ply fails by one of the criteria; the linear material is not valid beyond that load",
    "strength ratio below {limit:g}",
    "use a stronger lay-up or a lower load",
    limit=1.0,
)

CODES = (
    ENERGY_DRIFT,
    ENERGY_JUMP,
    MOMENTUM,
    SPIN,
    ROTATION,
    FEW_MODES,
    MATTERS,
    BUCKLING,
    BUCKLING_LOAD,
    INDEFINITE,
    NO_STIFFENING_DATA,
    PLY_FAILURE,
)
