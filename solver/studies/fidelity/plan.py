"""A plan: which model a run takes, and the packages and settings of the model and its check."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...dynamics.model.model import Model
from ...math.arrays import Array, IntArray
from ...mechanism.built_mechanism import BuiltMechanism
from ...package import ModalPackage
from ...package.body.selection import (
    axial_load,
    changed_basis,
    inertia_loads,
    rigid,
    vibrations,
    with_statics,
)
from ...run.inputs import RunSpec
from ..tolerances import FAINT

if TYPE_CHECKING:
    from ...inputs.case.tables.schema import Mechanism


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
    whole : it has all modes of the package that respond, as a check
    """

    vibrations: tuple[str, ...] = ()
    static: int = 0
    ringing: bool = False
    mesh: str = "model"
    whole: bool = False

    @property
    def rigid(self) -> bool:
        """True if the model has none of its deformation."""
        return not (self.vibrations or self.static or self.whole)


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
        """Return the plan with another model of one body; without a name, of all of them."""
        if not name:
            return replace(self, **changes)
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
                    **({"whole": True} if body.whole else {}),
                }
                for name, body in self.bodies.items()
            },
        }


def kind_of(label: str) -> str:
    """Return the kind of a vibration from its label, "bending-xy" of "bending-xy 3"."""
    return label.rpartition(" ")[0]


def number_of(label: str) -> int:
    """Return the number of a vibration in its kind, 3 of "bending-xy 3"; 1 without one."""
    number = label.rpartition(" ")[2]
    return int(number) if number.isdigit() else 1


def outline(plan: Plan) -> str:
    """Return a plan in a few words: modes of each body, stiffening, tolerance."""
    bodies = []
    for name, body in plan.bodies.items():
        ring = " undamped" if body.ringing and body.static else ""
        modes = f"{len(body.vibrations)}+{body.static}{ring}"
        bodies.append(f"{name} {'rigid' if body.rigid else modes}")
    stiffening = ", stiffening" if plan.stiffening else ""
    return f"{', '.join(bodies)}{stiffening}, rtol {plan.rtol:.1g}"


DAMPED = 0.2  # damping ratio of static shapes that do not ring: 1 would lag behind their loads
STATIC = 6  # static shapes of a body where a model without them cannot be assembled
TIGHT = 3e-5  # tolerance of a check at most
TIGHTEST = 2.5e-10
# So many times below that of the model. With 4, both runs missed the same high vibrations: joint
# forces of slider-cranks had four times the error that the check showed.
TIGHTER = 30.0
# Where the tolerance of the model follows from the size of small deflections, which is a
# conservative estimate. A check of slider-cranks takes 3 instead of 5 s.
TIGHTER_AMPLIFIED = 10.0
# Of rich packages, which ask for every mode; the check tells what the mesh of a plan costs.
REMARKS = ("static-modes-dependent", "mesh-coarse-for-modes")
MOST_STATIC = 16  # static shapes of a plan


@dataclass(frozen=True)
class Base:
    """A motion with its accelerations and multipliers at the output times.

    Attributes
    ----------
    built : the mechanism, with the packages of the base
    t, y : (k,), (k, n)
    accelerations, multipliers : (k, n_vel), (k, n_c)
    reason : why the bodies are not rigid in it; "" if they are
    """

    built: BuiltMechanism
    t: Array
    y: Array
    accelerations: Array
    multipliers: Array
    reason: str = ""

    @property
    def model(self) -> Model:
        """The model of the base."""
        return self.built.model


@dataclass(frozen=True)
class Rich:
    """The rich package of a body with the quasi-static response to the loads of the run.

    Attributes
    ----------
    eta : (k, m) K^-1 p at k output times
    further : returns the response (s, m) to the loads that deformation adds, by body
    """

    name: str
    package: ModalPackage
    eta: Array
    further: Callable[[], dict[str, Array]]

    def rest(self, kept: list[int], *, stiffening: bool = False) -> Array:
        """Static shapes (m, r) that the response needs beside the modes `kept`, largest first.

        Left singular vectors in the norm of the strain energy, times their singular values. With
        geometric stiffening, the response to the loads that it adds is part of the response.
        """
        root = np.linalg.cholesky(self.package.stiffness).T
        left = root @ self._needed(stiffening).T
        if kept:
            Q = np.linalg.qr(root[:, kept])[0]
            left = left - Q @ (Q.T @ left)
        U, s, _ = np.linalg.svd(left, full_matrices=False)
        return np.asarray(np.linalg.solve(root, U * s))

    def _needed(self, stiffening: bool) -> Array:
        return np.concatenate([self.eta, self.further()[self.name]]) if stiffening else self.eta

    def _responding(self, stiffening: bool) -> IntArray:
        """Rows of the modes that respond."""
        largest = np.abs(self._needed(stiffening)).max(axis=0, initial=0.0)
        size = np.sqrt(np.diag(self.package.stiffness)) * largest
        return np.flatnonzero(size > FAINT * float(size.max(initial=0.0)))

    def whole(self, *, stiffening: bool) -> BodyPlan:
        """Return the model of the body with all modes that respond."""
        some = set(self._responding(stiffening).tolist())
        free = [i for i in vibrations(self.package).tolist() if i in some]
        labels = tuple(self.package.mode_labels[i] for i in free)
        static = min(len(some) - len(free), MOST_STATIC)
        return BodyPlan(labels, static, True, "check", whole=True)

    def energies(self, shapes: Array) -> Array:
        """Square roots of the strain energies of shapes (m, r), (r,)."""
        return np.asarray(np.sqrt((shapes * (self.package.stiffness @ shapes)).sum(axis=0)))

    def of(self, body: BodyPlan, *, stiffening: bool) -> ModalPackage:
        """Return the package of a body with some of its vibrations and static shapes."""
        every = self.package.provenance.get("warnings", [])
        warnings = [item for item in every if item["code"] not in REMARKS]
        provenance = {**self.package.provenance, "warnings": warnings}
        package = replace(self.package, provenance=provenance)
        if body.whole:  # columns of the unit matrix
            some = self._responding(stiffening)
            return changed_basis(package, np.eye(package.n_mode)[:, some])
        kept = rows(package, body.vibrations)
        if not kept and not body.static:
            return rigid(package)
        shapes = self.rest(kept, stiffening=stiffening)
        usable = self.energies(shapes) > 1e-9 * energy(package, self.eta)
        loads = package.stiffness @ shapes[:, : min(body.static, int(np.sum(usable)))]
        if stiffening and body.static:
            loads = np.column_stack([axial_load(package), inertia_loads(package)[:, 0], loads])
        return with_statics(package, kept, loads, (), None if body.ringing else DAMPED)


def vibration_labels(package: ModalPackage) -> tuple[str, ...]:
    """Return the labels of the vibrations of a package."""
    return tuple(package.mode_labels[i] for i in vibrations(package).tolist())


def flexible_names(spec: RunSpec) -> list[str]:
    """Return the flexible bodies that a plan is about: those that the case does not make rigid."""
    bodies = spec.mechanism.bodies
    return [n for n, b in bodies.items() if b.kind != "rigid" and not b.rigid]


def known_vibrations(
    spec: RunSpec, check: Mapping[str, ModalPackage] | None = None
) -> dict[str, dict[str, tuple[str, ...]]]:
    """Return the vibrations that a plan may name, by body and mesh; without `check` of the model.

    Members of a sweep and designs have packages of the model only.
    """
    return {
        name: {
            "model": vibration_labels(spec.packages[name]),
            "check": vibration_labels(check[name]) if check is not None else (),
        }
        for name in flexible_names(spec)
    }


def rows(package: ModalPackage, labels: tuple[str, ...]) -> list[int]:
    """Return the rows of vibrations by label; those that the package does not have are left out."""
    return [i for i in vibrations(package).tolist() if package.mode_labels[i] in labels]


def energy(package: ModalPackage, q: Array) -> float:
    """Return the root of the sum of q' K q over rows of q (k, m)."""
    return float(np.sqrt(((q @ package.stiffness) * q).sum()))


def check_plan(plan: Plan, check: Mapping[str, Rich], tighter: float = TIGHTER) -> Plan:
    """Return the plan of a check: all modes that respond, no damping, tight.

    Parameters
    ----------
    tighter : tolerance of the plan over that of its check
    """
    second = any(rich.package.second_order is not None for rich in check.values())
    stiffening = plan.stiffening or second
    bodies = {name: check[name].whole(stiffening=stiffening) for name in plan.bodies}
    rtol = max(min(TIGHT, plan.rtol / tighter), TIGHTEST)
    return Plan(bodies, stiffening, rtol, plan.inputs_sha256)


def planned(
    spec: RunSpec, plan: Plan, model: Mapping[str, Rich], check: Mapping[str, Rich]
) -> RunSpec:
    """Return a run with the model of a plan.

    Parameters
    ----------
    spec : the run
    model, check : rich packages by body
    """
    packages = dict(spec.packages)
    for name, body in plan.bodies.items():
        rich = (check if body.mesh == "check" else model)[name]
        packages[name] = rich.of(body, stiffening=plan.stiffening)
    own = with_solver(spec.mechanism, plan.rtol, stiffening=plan.stiffening)
    return replace(spec, mechanism=own, packages=packages)


def with_solver(
    mechanism: "Mechanism", rtol: float, *, stiffening: bool, **values: Any
) -> "Mechanism":
    """Return a mechanism with other settings of its solver.

    Parameters
    ----------
    mechanism : of the case
    rtol : relative tolerance, from which the absolute ones follow
    stiffening : geometric stiffening
    values : other settings by key of `[solver]`
    """
    values |= {"rtol": rtol, "geometric_stiffening": stiffening}
    tolerances = dict.fromkeys(("atol_position", "atol_velocity"))
    solver = with_values(mechanism.solver, **values, **tolerances)
    changed: Mechanism = with_values(mechanism, solver=solver)
    return changed


def with_values(table: Any, **values: Any) -> Any:
    """Return a copy of a checked table (a model, or its record) with other values."""
    if hasattr(table, "model_copy"):
        return table.model_copy(update=values)
    return type(table)(**{**vars(table), **values})
