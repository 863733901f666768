"""A plan: which model a run takes."""

from dataclasses import dataclass, field, replace
from typing import Any

LEAST_RTOL, MOST_RTOL = 1e-9, 1e-3  # small deflections need the first: errors are of the size


@dataclass(frozen=True)
class BodyPlan:
    """What the model has of one flexible body.

    Attributes
    ----------
    vibrations : labels of the vibrations, as in the package
    static : number of static shapes of the loads that act on it in the run
    ringing : the static shapes are undamped; otherwise they have a damping ratio that suppresses
        their vibrations
    mesh : "model" or "check": package that its modes come from
    whole : it has all modes of the package that respond; of delivered runs only
    """

    vibrations: tuple[str, ...] = ()
    static: int = 0
    ringing: bool = False
    mesh: str = "model"
    whole: bool = False

    @property
    def rigid(self) -> bool:
        """True if the model has none of its deformation."""
        return not self.vibrations and not self.static


@dataclass(frozen=True)
class Plan:
    """The model of a run.

    Attributes
    ----------
    bodies : of the flexible bodies, by name
    stiffening : geometric stiffening
    rtol : tolerance of the integrator
    inputs_sha256 : of what it was made for; "" if it does not say
    """

    bodies: dict[str, BodyPlan]
    stiffening: bool
    rtol: float
    inputs_sha256: str = field(default="", compare=False)

    def with_body(self, name: str, **changes: Any) -> "Plan":
        """Return the plan with another model of one body."""
        return replace(self, bodies={**self.bodies, name: replace(self.bodies[name], **changes)})

    def table(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "rtol": self.rtol,
            "geometric_stiffening": self.stiffening,
            "bodies": {
                name: {
                    "vibrations": list(body.vibrations),
                    "static_shapes": body.static,
                    "ringing": body.ringing,
                    "mesh": body.mesh,
                }
                for name, body in self.bodies.items()
            },
        }


def kind_of(label: str) -> str:
    """Return the kind of a vibration from its label, "bending-xy" of "bending-xy 3"."""
    return label.rpartition(" ")[0]


def outline(plan: Plan) -> str:
    """Return a plan in a few words: modes of each body, stiffening, tolerance."""
    bodies = []
    for name, body in plan.bodies.items():
        ring = " undamped" if body.ringing and body.static else ""
        modes = f"{len(body.vibrations)}+{body.static}{ring}"
        bodies.append(f"{name} {'rigid' if body.rigid else modes}")
    stiffening = ", stiffening" if plan.stiffening else ""
    return f"{', '.join(bodies)}{stiffening}, rtol {plan.rtol:.1g}"
