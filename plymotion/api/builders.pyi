"""Functions of a case; written by `make docs` from the tables of the case file."""

import inspect
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

from ..solver.math.arrays import Array
from .keys import Keys

Number = float | str
Vector = Sequence[float] | Array | str

def kinds() -> Iterator[Any]: ...
def keys_of(kind: Any) -> dict[str, Any]: ...
def signature_of(kind: Any) -> inspect.Signature: ...
def text_of(kind: Any) -> str: ...

class Builders:
    __slots__ = ()

    def beam(
        self,
        name: str,
        *,
        interfaces: Mapping[str, Any],
        position: Vector | None = None,
        rotation_deg: Vector | None = None,
        velocity: Vector | None = None,
        angular_velocity: Vector | None = None,
        modal_coordinates: Mapping[str, Any] | None = None,
        modal_rates: Mapping[str, Any] | None = None,
        rigid: bool | None = None,
        reduced: Any = None,
        reference: Mapping[str, Any] | None = None,
        damping_ratio: Number | None = None,
        length: Number | None = None,
        line: Mapping[str, Any] | None = None,
        twist_deg: Any = None,
        table: str | None = None,
        section: str | None = None,
        stations: Any = None,
        segments: Number | None = None,
        material: str | None = None,
        ply_angle_deg: Number | None = None,
        x2_axis: Vector | None = None,
        elements: Number | None = None,
        theory: Literal['timoshenko', 'classical'] | None = None,
        part_of: str | None = None,
        mass_form: Literal['consistent', 'lumped'] | None = None,
        modes: Any = None,
    ) -> Keys:
        """Add a body of kind "beam": from the origin along body x, or along line.

        Parameters
        ----------
        name : of the table in the case
        position :
            frame origin at the start, global; joints are closed from this position [m];
            default [0.0, 0.0, 0.0]
        rotation_deg :
            rotation vector from global to body axes at the start [deg]; default [0.0, 0.0,
            0.0]
        velocity :
            of the frame origin at the start, global; absent: follows from the joints [m/s]
        angular_velocity :
            of the frame at the start, body axes; absent: follows from the joints with
            minimum kinetic energy [rad/s]
        modal_coordinates :
            at the start, by label or number of the mode, which `plymotion info PACKAGE`
            lists; joints are closed by the frames. With start = equilibrium, where the
            search begins
        modal_rates :
            at the start, likewise; of the others see solver.modes_at_start [1/s]
        rigid :
            the run takes the body as rigid, with the mass and inertia of its package;
            deflections, resultants and stresses are then 0; default False
        reduced :
            the modes that the run uses, as in `modes`: vibrations of the package, and
            static shapes rebuilt from all its modes; absent: all modes of the package
        reference :
            reference condition
        damping_ratio :
            of every mode of the body by itself; a mode of the mechanism at a lower
            frequency f, because the body carries masses, has about damping_ratio * f /
            f_body (docs/modes.md) [-]; default 0.0
        length :
            length along the beam; required, except for a line of points or nodes, which has
            a length [m]
        line :
            curved reference line: an arc, a spline through points, or given nodes; absent:
            straight along x
        twist_deg :
            pairs of a fraction of the length and the rotation of the section there about
            the line; linear between them [deg]; default []
        table :
            instead of length, line, twist_deg, section and stations: a CSV file with
            places, twist, 6x6 stiffness and mass along the beam (docs/blade.md), relative
            to the case file; `elements` then has a default of two between stations
        section :
            name of a section; with `stations`, of the one at the start; required without
            `table`
        stations :
            other sections along the beam; stiffness and mass are linear between them;
            default []
        segments :
            number of equal bodies, joined to each other, that form the beam, for large
            elastic rotations (docs/stiffening.md); `modes` are those of each; default 1
        material :
            name of a material; required by a shape, absent with a described section
        ply_angle_deg :
            fibre direction from x1 towards x2 about the outward normal x3, in solid shapes;
            absent: 0 [deg]
        x2_axis :
            direction of the section's x2 (width) in the body frame; normal to x [-];
            default [0.0, 1.0, 0.0]
        elements :
            beam elements along the length, of all segments; default 16
        theory :
            strains of the beam: all six, or classical without shear (closer to a solid for
            vibrating wide strips with bending-twist coupling); default 'timoshenko'
        part_of :
            of a segment, written by `check`: the body that it is a part of
        mass_form :
            inertia from consistent mass, or lumped (the paper); default 'consistent'
        modes :
            which modes the solver gets, at least one; of segments, those beside the static
            shapes of their ends; default []
        interfaces :
            named places; some carry the reference condition

        Returns
        -------
        the table, with keys as attributes
        """

    def shell(
        self,
        name: str,
        *,
        modes: Any,
        shell: str,
        interfaces: Mapping[str, Any],
        position: Vector | None = None,
        rotation_deg: Vector | None = None,
        velocity: Vector | None = None,
        angular_velocity: Vector | None = None,
        modal_coordinates: Mapping[str, Any] | None = None,
        modal_rates: Mapping[str, Any] | None = None,
        rigid: bool | None = None,
        reduced: Any = None,
        reference: Mapping[str, Any] | None = None,
        damping_ratio: Number | None = None,
        second_order: bool | None = None,
        parameters: Mapping[str, Any] | None = None,
        refine: Number | None = None,
        changes: Mapping[str, Any] | None = None,
        mass_form: Literal['consistent', 'lumped'] | None = None,
    ) -> Keys:
        """Add a body of kind "shell": a laminated shell, its axes those of the mesh.

        Parameters
        ----------
        name : of the table in the case
        position :
            frame origin at the start, global; joints are closed from this position [m];
            default [0.0, 0.0, 0.0]
        rotation_deg :
            rotation vector from global to body axes at the start [deg]; default [0.0, 0.0,
            0.0]
        velocity :
            of the frame origin at the start, global; absent: follows from the joints [m/s]
        angular_velocity :
            of the frame at the start, body axes; absent: follows from the joints with
            minimum kinetic energy [rad/s]
        modal_coordinates :
            at the start, by label or number of the mode, which `plymotion info PACKAGE`
            lists; joints are closed by the frames. With start = equilibrium, where the
            search begins
        modal_rates :
            at the start, likewise; of the others see solver.modes_at_start [1/s]
        rigid :
            the run takes the body as rigid, with the mass and inertia of its package;
            deflections, resultants and stresses are then 0; default False
        reduced :
            the modes that the run uses, as in `modes`: vibrations of the package, and
            static shapes rebuilt from all its modes; absent: all modes of the package
        reference :
            reference condition
        damping_ratio :
            of every mode of the body by itself; a mode of the mechanism at a lower
            frequency f, because the body carries masses, has about damping_ratio * f /
            f_body (docs/modes.md) [-]; default 0.0
        modes :
            which modes the solver gets
        second_order :
            second-order displacements of the modes, which geometric stiffening needs
            (docs/stiffening.md); default False
        shell :
            path of a shell description (docs/shell-description.md), relative to the case
            file
        parameters :
            of the mesh's script, over those of the description
        refine :
            number of refinements of the mesh, each with four cells in place of one: a
            script of meshes/shells gets twice its counts of cells, cells of other meshes
            are split at the middles of their straight sides; added to that of the
            description; default 0
        changes :
            other values at dotted keys of the description, in quotes: {
            "laminates.wall.angles_deg.1" = 30 }
        mass_form :
            inertia from consistent mass, or lumped (the paper); default 'consistent'
        interfaces :
            named places; some carry the reference condition

        Returns
        -------
        the table, with keys as attributes
        """

    def solid(
        self,
        name: str,
        *,
        modes: Any,
        solid: str,
        position: Vector | None = None,
        rotation_deg: Vector | None = None,
        velocity: Vector | None = None,
        angular_velocity: Vector | None = None,
        modal_coordinates: Mapping[str, Any] | None = None,
        modal_rates: Mapping[str, Any] | None = None,
        rigid: bool | None = None,
        reduced: Any = None,
        reference: Mapping[str, Any] | None = None,
        damping_ratio: Number | None = None,
        second_order: bool | None = None,
        size: Number | None = None,
        interfaces: Mapping[str, Any] | None = None,
    ) -> Keys:
        """Add a body of kind "solid": a part from CAD, its axes those of the file.

        Parameters
        ----------
        name : of the table in the case
        position :
            frame origin at the start, global; joints are closed from this position [m];
            default [0.0, 0.0, 0.0]
        rotation_deg :
            rotation vector from global to body axes at the start [deg]; default [0.0, 0.0,
            0.0]
        velocity :
            of the frame origin at the start, global; absent: follows from the joints [m/s]
        angular_velocity :
            of the frame at the start, body axes; absent: follows from the joints with
            minimum kinetic energy [rad/s]
        modal_coordinates :
            at the start, by label or number of the mode, which `plymotion info PACKAGE`
            lists; joints are closed by the frames. With start = equilibrium, where the
            search begins
        modal_rates :
            at the start, likewise; of the others see solver.modes_at_start [1/s]
        rigid :
            the run takes the body as rigid, with the mass and inertia of its package;
            deflections, resultants and stresses are then 0; default False
        reduced :
            the modes that the run uses, as in `modes`: vibrations of the package, and
            static shapes rebuilt from all its modes; absent: all modes of the package
        reference :
            reference condition
        damping_ratio :
            of every mode of the body by itself; a mode of the mechanism at a lower
            frequency f, because the body carries masses, has about damping_ratio * f /
            f_body (docs/modes.md) [-]; default 0.0
        modes :
            which modes the solver gets
        second_order :
            second-order displacements of the modes, which geometric stiffening needs
            (docs/stiffening.md); default False
        solid :
            path of a solid description (docs/solids.md), relative to the case file
        size :
            of the cells, over that of the description [m]
        interfaces :
            named places; some carry the reference condition; absent: those of the
            description

        Returns
        -------
        the table, with keys as attributes
        """

    def rigid(
        self,
        name: str,
        *,
        mass: Number,
        inertia: Any,
        position: Vector | None = None,
        rotation_deg: Vector | None = None,
        velocity: Vector | None = None,
        angular_velocity: Vector | None = None,
        centre: Vector | None = None,
        interfaces: Mapping[str, Any] | None = None,
        picture: str | None = None,
    ) -> Keys:
        """Add a body of kind "rigid": [bodies.NAME] with kind = "rigid".

        Parameters
        ----------
        name : of the table in the case
        position :
            frame origin at the start, global; joints are closed from this position [m];
            default [0.0, 0.0, 0.0]
        rotation_deg :
            rotation vector from global to body axes at the start [deg]; default [0.0, 0.0,
            0.0]
        velocity :
            of the frame origin at the start, global; absent: follows from the joints [m/s]
        angular_velocity :
            of the frame at the start, body axes; absent: follows from the joints with
            minimum kinetic energy [rad/s]
        mass :
            mass; 0 of a link whose others carry mass [kg]
        centre :
            mass centre in the body frame [m]; default [0.0, 0.0, 0.0]
        inertia :
            3x3 inertia about the mass centre, body axes, [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz],
            [Jxz, Jyz, Jzz]]; symmetric, positive definite; moments may be 0 if the mass is,
            or with allow = ["inertia"] [kg m2]
        interfaces :
            named places
        picture :
            for pictures only: path of an STL file in body axes [m], relative to the case
            file; absent: a box of the same inertia

        Returns
        -------
        the table, with keys as attributes
        """

    def package(
        self,
        name: str,
        *,
        package: str,
        position: Vector | None = None,
        rotation_deg: Vector | None = None,
        velocity: Vector | None = None,
        angular_velocity: Vector | None = None,
        modal_coordinates: Mapping[str, Any] | None = None,
        modal_rates: Mapping[str, Any] | None = None,
        rigid: bool | None = None,
        reduced: Any = None,
    ) -> Keys:
        """Add a body of kind "package": a modal package from a file.

        Parameters
        ----------
        name : of the table in the case
        position :
            frame origin at the start, global; joints are closed from this position [m];
            default [0.0, 0.0, 0.0]
        rotation_deg :
            rotation vector from global to body axes at the start [deg]; default [0.0, 0.0,
            0.0]
        velocity :
            of the frame origin at the start, global; absent: follows from the joints [m/s]
        angular_velocity :
            of the frame at the start, body axes; absent: follows from the joints with
            minimum kinetic energy [rad/s]
        modal_coordinates :
            at the start, by label or number of the mode, which `plymotion info PACKAGE`
            lists; joints are closed by the frames. With start = equilibrium, where the
            search begins
        modal_rates :
            at the start, likewise; of the others see solver.modes_at_start [1/s]
        rigid :
            the run takes the body as rigid, with the mass and inertia of its package;
            deflections, resultants and stresses are then 0; default False
        reduced :
            the modes that the run uses, as in `modes`: vibrations of the package, and
            static shapes rebuilt from all its modes; absent: all modes of the package
        package :
            path of the .vtkhdf file, relative to the case file

        Returns
        -------
        the table, with keys as attributes
        """

    def imported(
        self,
        name: str,
        *,
        file: str,
        position: Vector | None = None,
        rotation_deg: Vector | None = None,
        velocity: Vector | None = None,
        angular_velocity: Vector | None = None,
        modal_coordinates: Mapping[str, Any] | None = None,
        modal_rates: Mapping[str, Any] | None = None,
        rigid: bool | None = None,
        reduced: Any = None,
    ) -> Keys:
        """Add a body of kind "imported": matrices of another code, reduced when it is built.

        Parameters
        ----------
        name : of the table in the case
        position :
            frame origin at the start, global; joints are closed from this position [m];
            default [0.0, 0.0, 0.0]
        rotation_deg :
            rotation vector from global to body axes at the start [deg]; default [0.0, 0.0,
            0.0]
        velocity :
            of the frame origin at the start, global; absent: follows from the joints [m/s]
        angular_velocity :
            of the frame at the start, body axes; absent: follows from the joints with
            minimum kinetic energy [rad/s]
        modal_coordinates :
            at the start, by label or number of the mode, which `plymotion info PACKAGE`
            lists; joints are closed by the frames. With start = equilibrium, where the
            search begins
        modal_rates :
            at the start, likewise; of the others see solver.modes_at_start [1/s]
        rigid :
            the run takes the body as rigid, with the mass and inertia of its package;
            deflections, resultants and stresses are then 0; default False
        reduced :
            the modes that the run uses, as in `modes`: vibrations of the package, and
            static shapes rebuilt from all its modes; absent: all modes of the package
        file :
            path of the import file (TOML), relative to the case file

        Returns
        -------
        the table, with keys as attributes
        """

    def revolute(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis: Vector | None = None,
        drive: Mapping[str, Any] | None = None,
        start_deg: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "revolute": a hinge, one rotation.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            hinge axis at the start, global [-]; default [0.0, 0.0, 1.0]
        drive :
            prescribed rotation
        start_deg :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [deg]

        Returns
        -------
        the table, with keys as attributes
        """

    def fixed(
        self,
        name: str,
        one: str,
        two: str,
    ) -> Keys:
        """Add a joint of kind "fixed": no relative motion.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"

        Returns
        -------
        the table, with keys as attributes
        """

    def spherical(
        self,
        name: str,
        one: str,
        two: str,
    ) -> Keys:
        """Add a joint of kind "spherical": a common point, three rotations.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"

        Returns
        -------
        the table, with keys as attributes
        """

    def universal(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis_2: Vector,
        axis: Vector | None = None,
    ) -> Keys:
        """Add a joint of kind "universal": a common point and a cross with two axes.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            arm of the cross in the first place, at the start, global [-]; default [0.0,
            0.0, 1.0]
        axis_2 :
            arm in the second place, at a right angle to `axis` [-]

        Returns
        -------
        the table, with keys as attributes
        """

    def cylindrical(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis: Vector | None = None,
        rotation_drive: Mapping[str, Any] | None = None,
        start_deg: Number | None = None,
        translation_drive: Mapping[str, Any] | None = None,
        start: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "cylindrical": rotation about an axis, motion along it.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            axis at the start, global [-]; default [0.0, 0.0, 1.0]
        rotation_drive :
            prescribed rotation
        start_deg :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [deg]
        translation_drive :
            prescribed displacement
        start :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def prismatic(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis: Vector | None = None,
        drive: Mapping[str, Any] | None = None,
        start: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "prismatic": motion along an axis, no rotation.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            axis at the start, global [-]; default [0.0, 0.0, 1.0]
        drive :
            prescribed displacement
        start :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def planar(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis: Vector | None = None,
        drive: Mapping[str, Any] | None = None,
        start_deg: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "planar": motion in a plane, rotation about its normal.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            normal of the plane at the start, global [-]; default [0.0, 0.0, 1.0]
        drive :
            prescribed rotation
        start_deg :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [deg]

        Returns
        -------
        the table, with keys as attributes
        """

    def point_on_line(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis: Vector | None = None,
        drive: Mapping[str, Any] | None = None,
        start: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "point_on_line": the second place on a line of the first.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            line through the first place at the start, global [-]; default [0.0, 0.0, 1.0]
        drive :
            prescribed displacement
        start :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def distance(
        self,
        name: str,
        one: str,
        two: str,
        *,
        length: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "distance": two places a fixed length apart, a massless rod.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        length :
            absent: the distance in the given starting position [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def screw(
        self,
        name: str,
        one: str,
        two: str,
        *,
        lead: Number,
        axis: Vector | None = None,
        drive: Mapping[str, Any] | None = None,
        start_deg: Number | None = None,
    ) -> Keys:
        """Add a joint of kind "screw": rotation about an axis, motion along it in a fixed ratio.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            axis at the start, global [-]; default [0.0, 0.0, 1.0]
        lead :
            displacement along the axis for one turn about it, not 0; negative: left-handed
            [m]
        drive :
            prescribed rotation
        start_deg :
            coordinate at the start, from the given positions: bodies are moved so that the
            joints close with it; without a drive of it. With solver.start = equilibrium the
            search begins there [deg]

        Returns
        -------
        the table, with keys as attributes
        """

    def gear_pair(
        self,
        name: str,
        one: str,
        two: str,
        *,
        ratio: Number,
        coordinates: Any = None,
    ) -> Keys:
        """Add a coupling of kind "gear_pair": two rotations in a fixed ratio.

        Parameters
        ----------
        name : of the table in the case
        one, two : names of joints
        coordinates :
            of these joints; absent: the only rotation or displacement that each has
        ratio :
            rotation of the first joint over that of the second; negative: they turn in
            opposite directions, as two outer gears do

        Returns
        -------
        the table, with keys as attributes
        """

    def belt(
        self,
        name: str,
        one: str,
        two: str,
        *,
        radius_1: Number,
        radius_2: Number,
        coordinates: Any = None,
    ) -> Keys:
        """Add a coupling of kind "belt": two rotations by a belt that does not slip.

        Parameters
        ----------
        name : of the table in the case
        one, two : names of joints
        coordinates :
            of these joints; absent: the only rotation or displacement that each has
        radius_1 :
            of the pulley of the first joint [m]
        radius_2 :
            of the pulley of the second joint; negative: the belt is crossed [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def screw_drive(
        self,
        name: str,
        one: str,
        two: str,
        *,
        lead: Number,
        coordinates: Any = None,
    ) -> Keys:
        """Add a coupling of kind "screw_drive": a rotation that moves another joint along, as spindle and nut.

        Parameters
        ----------
        name : of the table in the case
        one, two : names of joints
        coordinates :
            of these joints; absent: the only rotation or displacement that each has
        lead :
            displacement of the second joint for one turn of the first; negative: left-
            handed [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def rack(
        self,
        name: str,
        one: str,
        two: str,
        *,
        radius: Number,
        coordinates: Any = None,
    ) -> Keys:
        """Add a coupling of kind "rack": a pinion that moves a rack along.

        Parameters
        ----------
        name : of the table in the case
        one, two : names of joints
        coordinates :
            of these joints; absent: the only rotation or displacement that each has
        radius :
            of the pinion; negative: a positive rotation moves the rack back [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def slide_pair(
        self,
        name: str,
        one: str,
        two: str,
        *,
        ratio: Number,
        coordinates: Any = None,
    ) -> Keys:
        """Add a coupling of kind "slide_pair": two displacements in a fixed ratio, as the fingers of a gripper.

        Parameters
        ----------
        name : of the table in the case
        one, two : names of joints
        coordinates :
            of these joints; absent: the only rotation or displacement that each has
        ratio :
            displacement of the first joint over that of the second

        Returns
        -------
        the table, with keys as attributes
        """

    def spring(
        self,
        name: str,
        one: str,
        two: str,
        *,
        stiffness: Number | None = None,
        damping: Number | None = None,
        length: Number | None = None,
        actuator: Mapping[str, Any] | None = None,
    ) -> Keys:
        """Add a force of kind "spring": spring, damper and actuator between two places.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        stiffness :
            k [N/m]; default 0.0
        damping :
            c [N s/m]; default 0.0
        length :
            of the spring without force; absent: the distance in the given starting position
            [m]
        actuator :
            force [N] that pushes the places apart

        Returns
        -------
        the table, with keys as attributes
        """

    def rotary_spring(
        self,
        name: str,
        one: str,
        two: str,
        *,
        axis: Vector | None = None,
        stiffness: Number | None = None,
        damping: Number | None = None,
        angle: Number | None = None,
        actuator: Mapping[str, Any] | None = None,
    ) -> Keys:
        """Add a force of kind "rotary_spring": spring, damper and actuator of a hinge.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            axis at the start, global [-]; default [0.0, 0.0, 1.0]
        stiffness :
            k [N m/rad]; default 0.0
        damping :
            c [N m s/rad]; default 0.0
        angle :
            angle without moment, from the given starting position [rad]; default 0.0
        actuator :
            torque [N m] on the second place about the axis

        Returns
        -------
        the table, with keys as attributes
        """

    def bushing(
        self,
        name: str,
        one: str,
        two: str,
        *,
        stiffness: Vector,
        axis: Vector | None = None,
        axis_1: Vector | None = None,
        rotary_stiffness: Vector | None = None,
        damping: Vector | None = None,
        rotary_damping: Vector | None = None,
    ) -> Keys:
        """Add a force of kind "bushing": springs and dampers on all six relative motions.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            third axis at the start, global; fixed in the first place [-]; default [0.0,
            0.0, 1.0]
        axis_1 :
            first axis, at a right angle to `axis`; absent: the global axis farthest from
            `axis`, made orthogonal [-]
        stiffness :
            along the three axes [N/m]
        rotary_stiffness :
            about the three axes [N m/rad]; default [0.0, 0.0, 0.0]
        damping :
            along the three axes [N s/m]; default [0.0, 0.0, 0.0]
        rotary_damping :
            about the three axes [N m s/rad]; default [0.0, 0.0, 0.0]

        Returns
        -------
        the table, with keys as attributes
        """

    def force(
        self,
        name: str,
        at: str,
        *,
        direction: Vector,
        law: Mapping[str, Any],
        frame: Literal['global', 'following'] | None = None,
    ) -> Keys:
        """Add a force of kind "force": a force [N] from outside.

        Parameters
        ----------
        name : of the table in the case
        at :
            "BODY.INTERFACE"
        direction :
            at the start, global; only the direction counts [-]
        frame :
            the direction is fixed, or rotates with the interface; default 'global'
        law :
            magnitude over time, along the direction

        Returns
        -------
        the table, with keys as attributes
        """

    def torque(
        self,
        name: str,
        at: str,
        *,
        direction: Vector,
        law: Mapping[str, Any],
        frame: Literal['global', 'following'] | None = None,
    ) -> Keys:
        """Add a force of kind "torque": a torque [N m] from outside.

        Parameters
        ----------
        name : of the table in the case
        at :
            "BODY.INTERFACE"
        direction :
            at the start, global; only the direction counts [-]
        frame :
            the direction is fixed, or rotates with the interface; default 'global'
        law :
            magnitude over time, along the direction

        Returns
        -------
        the table, with keys as attributes
        """

    def coordinate_force(
        self,
        name: str,
        *,
        expression: str,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
    ) -> Keys:
        """Add a force of kind "coordinate_force": a force along a coordinate, by an expression.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        expression :
            force that pushes the coordinate up; reads `x`, its rate `v`, `t` and more, see
            expressions.md [N or N m]

        Returns
        -------
        the table, with keys as attributes
        """

    def nonlinear_spring(
        self,
        name: str,
        *,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
        force_displacement: Mapping[str, Any] | None = None,
        force_velocity: Mapping[str, Any] | None = None,
        length: Number | None = None,
    ) -> Keys:
        """Add a force of kind "nonlinear_spring": a spring and damper with given curves.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        force_displacement :
            force against the coordinate, over the coordinate [m or rad] [N or N m]
        force_velocity :
            force against the motion, over the rate of the coordinate [m/s or rad/s] [N or N
            m]
        length :
            value of the coordinate that `force_displacement` counts from; absent: 0 [m or
            rad]

        Returns
        -------
        the table, with keys as attributes
        """

    def limit_stop(
        self,
        name: str,
        *,
        stiffness: Number,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
        lower: Number | None = None,
        upper: Number | None = None,
        exponent: Number | None = None,
        restitution: Number | None = None,
        impact_speed: Number | None = None,
    ) -> Keys:
        """Add a force of kind "limit_stop": a contact that keeps a coordinate between limits.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        lower :
            limit of the coordinate; absent: none [m or rad]
        upper :
            limit of the coordinate; absent: none [m or rad]
        stiffness :
            k [N/m^n or N m/rad^n]
        exponent :
            n; 1.5: Hertz; default 1.5
        restitution :
            speed after an impact over that before it; default 1.0
        impact_speed :
            speed for which `restitution` holds; absent: it holds for every impact [m/s or
            rad/s]

        Returns
        -------
        the table, with keys as attributes
        """

    def contact(
        self,
        name: str,
        one: str,
        two: str,
        *,
        stiffness: Number,
        axis: Vector | None = None,
        radius: Number | None = None,
        other_radius: Number | None = None,
        disc_axis: Vector | None = None,
        exponent: Number | None = None,
        restitution: Number | None = None,
        impact_speed: Number | None = None,
        coefficient: Number | None = None,
        rest_velocity: Number | None = None,
    ) -> Keys:
        """Add a force of kind "contact": a contact of a sphere, a point or the rim of a disc with a plane, or of two spheres.

        Parameters
        ----------
        name : of the table in the case
        one, two : places, "BODY.INTERFACE" or "ground.POINT"
        axis :
            normal of the plane at the start, global, towards the sphere; fixed in the first
            place; absent: z [-]
        radius :
            of the sphere at the second place; 0: a point [m]; default 0.0
        other_radius :
            of a sphere at the first place; absent: a plane [m]
        disc_axis :
            axis at the start, global, of a thin disc about the second place, whose rim
            touches the plane; absent: a sphere [-]
        stiffness :
            k [N/m^n or N m/rad^n]
        exponent :
            n; 1.5: Hertz; default 1.5
        restitution :
            speed after an impact over that before it; default 1.0
        impact_speed :
            speed for which `restitution` holds; absent: it holds for every impact [m/s or
            rad/s]
        coefficient :
            of Coulomb's friction; default 0.0
        rest_velocity :
            sliding at which friction has 1 / sqrt(2) of its size [m/s]; default 0.001

        Returns
        -------
        the table, with keys as attributes
        """

    def friction(
        self,
        name: str,
        *,
        rest_velocity: Number,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
        coulomb: Number | None = None,
        static: Number | None = None,
        coefficient: Number | None = None,
        static_coefficient: Number | None = None,
        radius: Number | None = None,
        collar_radius: Number | None = None,
        length: Number | None = None,
        stribeck_velocity: Number | None = None,
        viscous: Number | None = None,
    ) -> Keys:
        """Add a force of kind "friction": friction of Coulomb and Stribeck.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        coulomb :
            friction of fast sliding that does not depend on the reaction; it or
            `coefficient` [N or N m]; default 0.0
        static :
            friction at the onset of sliding; absent: `coulomb` [N or N m]
        coefficient :
            of friction by the reaction of the joint, at fast sliding; absent: none
        static_coefficient :
            the same at the onset of sliding; absent: `coefficient`
        radius :
            of the pin of a hinge; of a slider the arm at which it is held against rotation,
            absent: no friction by the moment about its axis; in a cylindrical joint that of
            the shaft: friction is then against its velocity along and around the axis
            together [m]
        collar_radius :
            of the collar that takes the force along the axis of a hinge; absent: no
            friction there [m]
        length :
            of the bearing or guide, which takes moments across the axis at its ends;
            absent: no friction by them [m]
        stribeck_velocity :
            over which friction falls from `static` to `coulomb`, from `static_coefficient`
            to `coefficient`; absent only where they are equal [m/s or rad/s]
        viscous :
            coefficient of viscous friction [N s/m or N m s/rad]; default 0.0
        rest_velocity :
            speed below which the direction of sliding is smoothed [m/s or rad/s]

        Returns
        -------
        the table, with keys as attributes
        """

    def bristle_friction(
        self,
        name: str,
        *,
        bristle_stiffness: Number,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
        coulomb: Number | None = None,
        static: Number | None = None,
        coefficient: Number | None = None,
        static_coefficient: Number | None = None,
        radius: Number | None = None,
        collar_radius: Number | None = None,
        length: Number | None = None,
        stribeck_velocity: Number | None = None,
        viscous: Number | None = None,
        bristle_damping: Number | None = None,
    ) -> Keys:
        """Add a force of kind "bristle_friction": friction that sticks and slides, the LuGre model.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        coulomb :
            friction of fast sliding that does not depend on the reaction; it or
            `coefficient` [N or N m]; default 0.0
        static :
            friction at the onset of sliding; absent: `coulomb` [N or N m]
        coefficient :
            of friction by the reaction of the joint, at fast sliding; absent: none
        static_coefficient :
            the same at the onset of sliding; absent: `coefficient`
        radius :
            of the pin of a hinge; of a slider the arm at which it is held against rotation,
            absent: no friction by the moment about its axis; in a cylindrical joint that of
            the shaft: friction is then against its velocity along and around the axis
            together [m]
        collar_radius :
            of the collar that takes the force along the axis of a hinge; absent: no
            friction there [m]
        length :
            of the bearing or guide, which takes moments across the axis at its ends;
            absent: no friction by them [m]
        stribeck_velocity :
            over which friction falls from `static` to `coulomb`, from `static_coefficient`
            to `coefficient`; absent only where they are equal [m/s or rad/s]
        viscous :
            coefficient of viscous friction [N s/m or N m s/rad]; default 0.0
        bristle_stiffness :
            of the contact before it slides [N/m or N m/rad; by coefficient: 1/m or 1/rad]
        bristle_damping :
            of the contact before it slides [N s/m or N m s/rad; by coefficient: s/m or
            s/rad]; default 0.0

        Returns
        -------
        the table, with keys as attributes
        """

    def controller(
        self,
        name: str,
        *,
        setpoint: str,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
        sensor: str | None = None,
        proportional: Number | None = None,
        integral: Number | None = None,
        derivative: Number | None = None,
        filter_time: Number | None = None,
        feedforward: str | None = None,
        lower: Number | None = None,
        upper: Number | None = None,
        anti_windup_time: Number | None = None,
        gear_ratio: Number | None = None,
        sample_time: Number | None = None,
    ) -> Keys:
        """Add a force of kind "controller": a PID controller.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        setpoint :
            what the sensor is to follow
        sensor :
            what is measured; `x`: the coordinate; default 'x'
        proportional :
            gain kp [N or N m by sensor]; default 0.0
        integral :
            gain ki [as proportional, 1/s]; default 0.0
        derivative :
            gain kd [as proportional, s]; default 0.0
        filter_time :
            time constant of the first-order filter of the derivative; 0: none [s]; default
            0.0
        feedforward :
            added to the demand [N or N m]; default '0'
        lower :
            limit of the output; absent: none [N or N m]
        upper :
            limit of the output; absent: none [N or N m]
        anti_windup_time :
            in which the integral goes back at a limit; absent: proportional / integral [s]
        gear_ratio :
            force along the coordinate over the output; default 1.0
        sample_time :
            between the instants at which it acts, its output held; absent: continuous [s]

        Returns
        -------
        the table, with keys as attributes
        """

    def python_controller(
        self,
        name: str,
        *,
        code: Mapping[str, Any],
        inputs: Sequence[str],
        sample_time: Number,
        joint: str | None = None,
        coordinate: Literal['angle', 'angle_2', 'x', 'y', 'z'] | None = None,
        between: Sequence[str] | None = None,
    ) -> Keys:
        """Add a force of kind "python_controller": a controller written in Python.

        Parameters
        ----------
        name : of the table in the case
        joint :
            the joint whose coordinate it acts along; or `between`
        coordinate :
            of the joint; absent: the only one that it has
        between :
            in place of `joint`, two places: the coordinate is their distance
        code :
            function(t, inputs, memory) of a Python file, which returns the force
        inputs :
            what the function gets as an array, in this order
        sample_time :
            between the instants at which it is called [s]

        Returns
        -------
        the table, with keys as attributes
        """

    def point(
        self,
        name: str,
        position: Vector,
    ) -> Keys:
        """Add a point of the ground: a point of the ground, used as "ground.NAME".

        Parameters
        ----------
        name : of the table in the case
        position :
            global [m]

        Returns
        -------
        the table, with keys as attributes
        """

    def mass(
        self,
        name: str,
        mass: Number,
        at: str,
    ) -> Keys:
        """Add a point mass: a point mass on a body.

        Parameters
        ----------
        name : of the table in the case
        mass :
            mass [kg]
        at :
            "BODY.INTERFACE"

        Returns
        -------
        the table, with keys as attributes
        """
