"""Kratos: shells of four nodes on the grids of our plates and cylinders, co-rotational beams.

Its documented choices: MITC shells with the law of Reissner and Mindlin, and thin shells, whose
elements are right for small displacements, too; plies are layers of its older thick shells.
Newton's method in eight parts, SparseLU, Spectra's shifted modes.
"""

from typing import Any

import description
import numpy as np
from common import Sheet, Timed, main
from in_calculix import DOFS, grid, no_grid, shares

NAME = "Kratos"
PARTS = ("Multiphysics", "StructuralMechanicsApplication", "LinearSolversApplication")
PARTS += ("ConstitutiveLawsApplication",)
ENVIRONMENT: dict[str, Any] = {"pip": [f"Kratos{part}==10.4.4" for part in PARTS]}
HELD = {"all": DOFS, "symmetry-x": ("ux", "ry", "rz"), "symmetry-y": ("uy", "rx", "rz")}
HELD |= {"symmetry-z": ("uz", "rx", "ry")}
SHELLS = ("MITCThickShellElement3D4N", "ShellThinElementCorotational3D4N")


def cannot(sheet: Sheet) -> str:
    """Shells on grids; beams at rest."""
    if "beam" in sheet:
        return "" if sheet["beam"].get("static") else "beams at rest only in this runner"
    if sheet["kind"] != "shell":
        return "a finite-element code: shells and beams here"
    table = description.read_toml(sheet)
    return "no buckling in this runner" if "buckling" in table else no_grid(table)


def settings(sheet: Sheet) -> list[Sheet]:
    """Cells along each side, elements of a beam."""
    if "beam" in sheet:
        return [{"method": "CrBeamElement3D2N", "elements": n} for n in (4, 8, 16, 32, 64)]
    laminate = "laminates" in description.read_toml(sheet)
    some = [SHELLS[0].replace("MITC", "Legacy")] if laminate else SHELLS
    return [{"method": method, "cells": n} for method in some for n in (8, 16, 32, 64)]


def part_of(places: Any) -> tuple[Any, dict[str, Any]]:
    """A model part with its nodes; unknowns by our names."""
    part = MODEL.CreateModelPart("main", 2)
    for word in ("DISPLACEMENT", "ROTATION", "REACTION", "REACTION_MOMENT", "VOLUME_ACCELERATION"):
        part.AddNodalSolutionStepVariable(getattr(KM, word))
    part.AddNodalSolutionStepVariable(SMA.POINT_LOAD)
    part.AddNodalSolutionStepVariable(SMA.SURFACE_LOAD)
    for k, place in enumerate(places):
        part.CreateNewNode(k + 1, *map(float, place))
    dofs = {}
    for kind, pair in (("u", ("DISPLACEMENT", "REACTION")), ("r", ("ROTATION", "REACTION_MOMENT"))):
        for axis in "xyz":
            dof, against = (getattr(KM, f"{word}_{axis.upper()}") for word in pair)
            KM.VariableUtils().AddDof(dof, against, part)
            dofs[kind + axis] = dof
    return part, dofs


def load(part: Any, kind: str, nodes: list[int]) -> None:
    """A load of the variables of its nodes."""
    part.CreateNewCondition(kind, part.NumberOfConditions() + 1, nodes, part.Properties[1])


def shell(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """A shell on a grid; the displacement of the probe, or the first frequency."""
    table, n = description.read_toml(sheet), setting["cells"]
    (places, number), sets = grid(table["mesh"], n // 2)
    sets["centre"] = [int(number[n // 2, n // 2])]
    (name, path), *_ = sheet["values"].items()
    with Timed() as used:
        part, dofs = part_of(places.reshape(-1, 3))
        material(part.CreateNewProperties(1), table, setting["method"])
        rings = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        rings = np.stack(rings, axis=2).reshape(-1, 4).tolist()
        for k, ring in enumerate(rings):
            part.CreateNewElement(setting["method"], k + 1, ring, part.Properties[1])
        for support in table["supports"].values():
            fixed = support["fixed"]
            for node in sets[support["at"]]:
                for dof in HELD[fixed] if isinstance(fixed, str) else fixed:
                    part.Nodes[node].Fix(dofs[dof])
        if path[0] == "frequencies_hz":
            options = KM.Parameters('{"solver_type": "spectra_sym_g_eigs_shift"}')
            solver = LSA.SpectraSymGEigsShiftSolver(options)
            builder = KM.ResidualBasedBlockBuilderAndSolver(solver)
            scheme = SMA.EigensolverDynamicScheme()
            strategy = SMA.EigensolverStrategy(part, scheme, builder, 0.0, 1.0)
        else:
            for case in table["loads"].values():
                for entry in [case] if "at" in case else case.values():
                    if "force_per_area" in entry:
                        spread(part, entry, places, rings)
                        continue
                    nodes = sets[entry["at"]]
                    for node, share in zip(nodes, shares(len(nodes), 2.0), strict=True):
                        force = KM.Vector((share * np.array(entry["force"])).tolist())
                        part.Nodes[node].SetSolutionStepValue(SMA.POINT_LOAD, 0, force)
                        load(part, "PointLoadCondition3D1N", [node])
            scheme = KM.ResidualBasedIncrementalUpdateStaticScheme()
            builder = KM.ResidualBasedBlockBuilderAndSolver(LSA.SparseLUSolver())
            strategy = KM.ResidualBasedLinearStrategy(part, scheme, builder, *[False] * 4)
        strategy.Initialize()
        strategy.Solve()
    if path[0] == "frequencies_hz":
        square = part.ProcessInfo[SMA.EIGENVALUE_VECTOR][0]
        return {name: float(np.sqrt(square) / (2.0 * np.pi))}, used.seconds
    probe = part.Nodes[sets[table["probes"][path[3]]["at"]][0]]
    return {name: abs(probe.GetSolutionStepValue(dofs[path[-1]]))}, used.seconds


def spread(part: Any, entry: Sheet, places: Any, rings: Any) -> None:
    """A force per area, even or as sines."""
    values = np.broadcast_to(np.array(entry["force_per_area"]), places.shape)
    if "sine" in entry:
        flat = places[..., :2] / places[-1, -1, :2]  # of a plate from the origin
        values = (
            values * np.prod(np.sin(np.pi * np.array(entry["sine"][:2]) * flat), axis=2)[..., None]
        )
    for node, value in zip(part.Nodes, values.reshape(-1, 3), strict=True):
        node.SetSolutionStepValue(SMA.SURFACE_LOAD, 0, KM.Vector(value.tolist()))
    for ring in rings:
        load(part, "SurfaceLoadCondition3D4N", ring)


def material(found: Any, table: Sheet, kind: str) -> None:
    """Thickness and law of the shell, or its layers."""
    (region,) = table["regions"].values()
    laminate = table.get("laminates", {}).get(region.get("laminate"), {})
    own = table["materials"][laminate.get("material", region.get("material"))]
    found.SetValue(KM.DENSITY, own["rho"])
    if not laminate:
        found.SetValue(KM.YOUNG_MODULUS, own["E"])
        found.SetValue(KM.POISSON_RATIO, own["nu"])
        found.SetValue(KM.THICKNESS, region["thickness"])
        thick = SMA.ReissnerMindlinShellElasticConstitutiveLaw
        law = thick if "MITC" in kind else SMA.LinearElasticPlaneStress2DLaw
        found.SetValue(KM.CONSTITUTIVE_LAW, law())
        return
    angles = laminate["angles_deg"] + laminate["angles_deg"][::-1] * laminate.get(
        "symmetric", False
    )
    layers = KM.Matrix(len(angles), 9)
    for i, angle in enumerate(angles):
        row = [own[k] for k in ("rho", "E1", "E2", "nu12", "G12", "G13", "G23")]
        for j, value in enumerate([laminate["ply_thickness"], angle, *row]):
            layers[i, j] = value
    found.SetValue(SMA.SHELL_ORTHOTROPIC_LAYERS, layers)
    found.SetValue(KM.CONSTITUTIVE_LAW, CLA.LinearElasticOrthotropic2DLaw())


def beam(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """A clamped beam in space under a dead force at its end."""
    b, n = sheet["beam"], setting["elements"]
    s = np.linspace(0.0, b["length"], n + 1)
    a = b["curvature"][2] * s
    places = [s * np.sinc(a / np.pi), s * np.sinc(a / (2 * np.pi)) * np.sin(a / 2), 0.0 * s]
    K = np.diag(b["K"]).tolist()
    data = {"YOUNG_MODULUS": 1.0, "POISSON_RATIO": 0.0, "DENSITY": 1.0, "CROSS_AREA": K[0]}
    data |= {"I22": K[4], "I33": K[5], "TORSIONAL_INERTIA": 2.0 * K[3]}
    data |= {"AREA_EFFECTIVE_Y": 2.0 * K[1], "AREA_EFFECTIVE_Z": 2.0 * K[2]}
    with Timed() as used:
        part, dofs = part_of(np.array(places).T)
        found = part.CreateNewProperties(1)
        for key, value in data.items():
            found.SetValue(getattr(KM, key, None) or getattr(SMA, key), value)
        found.SetValue(KM.CONSTITUTIVE_LAW, SMA.BeamConstitutiveLaw())
        for k, middle in enumerate((a[1:] + a[:-1]) / 2):
            element = part.CreateNewElement(setting["method"], k + 1, [k + 1, k + 2], found)
            across = KM.Vector([-np.sin(middle), np.cos(middle), 0.0])
            element.SetValue(KM.LOCAL_AXIS_2, across)
        for dof in dofs.values():
            part.Nodes[1].Fix(dof)
        load(part, "PointLoadCondition3D1N", [n + 1])
        scheme = KM.ResidualBasedIncrementalUpdateStaticScheme()
        builder = KM.ResidualBasedBlockBuilderAndSolver(LSA.SparseLUSolver())
        until = KM.ResidualCriteria(1e-6, 1e-7)
        strategy = KM.ResidualBasedNewtonRaphsonStrategy(
            part, scheme, until, builder, 50, False, False, True
        )
        strategy.Initialize()
        tip = part.Nodes[n + 1]
        for step in range(1, 9):
            part.CloneTimeStep(float(step))
            force = KM.Vector((step / 8 * np.array(b["force"])).tolist())
            tip.SetSolutionStepValue(SMA.POINT_LOAD, 0, force)
            strategy.Solve()
            if not strategy.IsConverged():
                raise RuntimeError("Newton's method did not converge")
    return [[tip.X, tip.Y, tip.Z]], used.seconds


if __name__ == "__main__":
    import KratosMultiphysics as KM
    import KratosMultiphysics.ConstitutiveLawsApplication as CLA
    import KratosMultiphysics.LinearSolversApplication as LSA
    import KratosMultiphysics.StructuralMechanicsApplication as SMA

    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    MODEL = KM.Model()
    main(lambda sheet, setting: (beam if "beam" in sheet else shell)(sheet, setting))
