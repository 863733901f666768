"""Specifications of the flexible bodies of a case, and the two of each that `[fidelity]` compares.

The plan takes the model from the first. The check run uses the second, which has a finer mesh, more
vibrations and all load shapes, because a check within one package cannot see what it lacks.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from ....dynamics.elements.forces.table import FORCES
from ....errors import InputError, nearest, under, unknown
from ....math.disk_cache import file_sha256
from ....package.body.invariants import MOST_MODES
from ....package.common.plain_data import inputs_sha256
from ....package.specification import DIRECTIONS, ImportedSpecification, Specification
from ...common.mesh_files import files_read
from ...common.text_file import read_toml
from ..record import loaded_places
from ..tables.beam_keys import BeamBody
from ..tables.bodies import ImportedBody, Placed, Reducible, ShellBody, SolidBody
from ..tables.schema import Mechanism
from ..tables.signals import PlyStressSignal
from .beams import beam_spec
from .descriptions import shell_body_spec, solid_body_spec


def imported_spec(
    name: str, body: ImportedBody, folder: Path
) -> tuple[ImportedSpecification, list[Path]]:
    """Return the specification of an imported body, and the files that it is made from.

    The preprocessor checks the keys of the import file.

    Parameters
    ----------
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        The import file or a file that it names is missing.
    """
    key = f'bodies.{name}.import = "{body.file}"'
    file = folder / body.file
    try:
        table = read_toml(file, "import file")
    except InputError as error:
        raise under(key, error) from error
    paths = _files(table, file, key)
    spec: ImportedSpecification = {
        "body": name,
        "kind": "imported",
        "file": os.path.relpath(file),
        "table": table,
        "sha256": {name: file_sha256(path) for name, path in paths.items()},
    }
    return spec, [file, *paths.values()]


def _files(table: Mapping[str, Any], file: Path, key: str) -> dict[str, Path]:
    """Files that the import file names, and those of the same stem beside a deck."""
    named = table.get("files")
    if not isinstance(named, dict) or not all(isinstance(v, str) for v in named.values()):
        raise InputError(f"{key}: files = {named!r}: expected a table of paths")
    files = {}
    for word, name in named.items():
        path = file.parent / name
        if not path.is_file():
            listed = [item.name for item in path.parent.glob("*")] if path.parent.is_dir() else []
            hint = nearest(path.name, listed)
            raise InputError(f"{key}: files.{word} = {name!r}: no such file{hint}")
        files[name] = path
        if word == "deck":
            beside = [path.with_suffix(each) for each in (".sti", ".mas", ".dof", ".frd")]
            read = [*files_read(path), *(item for item in beside if item.is_file())]
            files |= {os.path.relpath(item, file.parent): item for item in read}
    return files


# Where a body starts, and what a run uses of it, say nothing about its package.
STATE = {*Placed.model_fields, *Reducible.model_fields}


@dataclass(frozen=True)
class BodySpec:
    """What the preprocessor needs to build one flexible body.

    Attributes
    ----------
    content : plain JSON, SI and degrees
    inputs_sha256 : hash of the content that the body depends on
    sources : files beside the case file that it is made from
    """

    content: Specification
    inputs_sha256: str
    sources: tuple[Path, ...]


@dataclass(frozen=True)
class BodySpecs:
    """Specifications of a case; runs and members of sweeps with the same body share one.

    Attributes
    ----------
    folder : of the case file, where relative paths start
    units : of lengths in the case file
    """

    folder: Path
    units: str = "m"
    _known: dict[tuple[str, ...], BodySpec] = field(default_factory=dict)

    def of(
        self,
        name: str,
        body: BeamBody | ShellBody | SolidBody | ImportedBody,
        mechanism: Mechanism,
        *,
        candidates: bool = False,
    ) -> BodySpec:
        """Return the specification of a body, whose section and material exist.

        Parameters
        ----------
        candidates : a plan of `[fidelity]` takes some of the modes of a beam or shell

        Raises
        ------
        InputError
            Lines that begin with the key: what is wrong with the body.
        """
        parts: list[BaseModel] = []
        if isinstance(body, BeamBody):
            used = [(s.section, s.material) for s in body.stations]
            for section, material in [(body.section, body.material), *used]:
                if section is None:
                    continue
                parts.append(mechanism.sections[section])
                if getattr(parts[-1], "description", None) is not None:
                    parts += mechanism.materials.values()  # which it may use
                if material is not None:
                    parts.append(mechanism.materials[material])
        own = body.model_dump_json(exclude=STATE)
        errors = mechanism.solver.error_bars and isinstance(body, BeamBody)
        key = (name, own, f"{candidates} {errors}", *(part.model_dump_json() for part in parts))
        if key not in self._known:
            content: Specification
            if isinstance(body, BeamBody):
                content, sources = beam_spec(name, body, mechanism, self.folder)
            elif isinstance(body, ShellBody):
                content, sources = shell_body_spec(name, body, self.folder)
            elif isinstance(body, SolidBody):
                content, sources = solid_body_spec(name, body, self.folder)
            else:
                content, sources = imported_spec(name, body, self.folder)
            if candidates and content["kind"] in ("beam", "shell"):
                content["candidates"] = True
            digest = inputs_sha256(content)  # a package without errors is of the same body
            if errors and content["kind"] == "beam":
                content["errors"] = True
            read = {each for file in sources for each in files_read(file)}
            self._known[key] = BodySpec(content, digest, tuple(sorted(read)))
        return self._known[key]


# Vibrations of a beam by kind, of the model and of the check.
BEAM_VIBRATIONS = {"bending-xy": (4, 6), "bending-xz": (4, 6), "torsion": (2, 3), "axial": (2, 3)}
SHELL_VIBRATIONS = (12, 18)  # lowest, of any kind
LOAD_SHAPES = 7  # static-inertia and static-axial
LEAST_ELEMENTS = 24  # of the model: converged for its highest bending mode
FINER = 2  # elements of the check over those of the model


def check_fidelity(mechanism: Mechanism) -> list[str]:
    """Return what is wrong with `[fidelity]` of a run, one line each."""
    fidelity = mechanism.fidelity
    if fidelity is None:
        return []
    errors = []
    for name in fidelity.signals or []:
        errors += unknown("fidelity.signals", name, "signal", mechanism.signals)
    for name in fidelity.signals or mechanism.signals:
        signal = mechanism.signals.get(name)
        if isinstance(signal, PlyStressSignal) and signal.point is None:
            errors.append(
                f"signals.{name}.point: missing; expected with [fidelity], because the point of "
                "the largest stress is another one in each run"
            )
    if not mechanism.signals:
        errors.append("fidelity: expected at least one signal in the case")
    if mechanism.solver.error_bars:
        errors.append("solver.error_bars: expected false with [fidelity], which states errors")
    for name, body in mechanism.bodies.items():
        if isinstance(body, Reducible) and body.reduced is not None:
            errors.append(
                f"bodies.{name}.reduced: expected none with [fidelity], which chooses the modes"
            )
    return errors


def rich_bodies(name: str, mechanism: Mechanism) -> tuple[Any, Any]:
    """Return a flexible body as the model and the check of `[fidelity]` need it."""
    body: BeamBody | ShellBody = mechanism.bodies[name]  # type: ignore[assignment]
    return _rich(name, body, mechanism, 0), _rich(name, body, mechanism, 1)


TURNING = frozenset(kind for kind, element in FORCES.items() if element.turns)


def _rich(name: str, body: BeamBody | ShellBody, mechanism: Mechanism, which: int) -> Any:
    clamped = body.reference.places[0] if body.reference.kind == "clamped" else None
    loaded = loaded_places(name, mechanism)
    counts = BEAM_VIBRATIONS if body.kind == "beam" else {"lowest": SHELL_VIBRATIONS}
    tables: list[dict[str, object]]
    tables = [{"kind": kind, "count": both[which]} for kind, both in counts.items()]
    places = [place for place in body.interfaces if place in loaded and place != clamped]
    # All directions of each, unless second-order displacements of so many modes are left out.
    most = MOST_MODES - LOAD_SHAPES - sum(check for _, check in counts.values())
    turned = places if 6 * len(places) <= most else loaded_places(name, mechanism, TURNING)
    tables += [
        {
            "kind": "attachment",
            "at": place,
            "directions": list(DIRECTIONS[: 6 if place in turned else 3]),
        }
        for place in places
    ]
    if body.reference.kind != "mean-axis":  # which carries them
        tables.append({"kind": "static-inertia"})
    tables.append({"kind": "static-axial"})
    content = {**body.model_dump(), "modes": tables}
    if body.kind == "beam":
        content["elements"] = max(body.elements, LEAST_ELEMENTS) * (FINER if which else 1)
    elif which:
        content["refine"] = body.refine + 1
    return type(body).model_validate(content)


CHECK = ".check"  # after the name of a body: its package of the check


def model_and_check(
    specs: Mapping[str, BodySpec],
) -> tuple[dict[str, BodySpec], dict[str, BodySpec]]:
    """Separate what belongs to the bodies of a case from what belongs to their check packages."""
    check = {n.removesuffix(CHECK): s for n, s in specs.items() if n.endswith(CHECK)}
    return {n: s for n, s in specs.items() if not n.endswith(CHECK)}, check
