"""Specifications of the flexible bodies of a case: built once, checked once, kept for writing."""

from dataclasses import dataclass, field
from pathlib import Path

from pydantic import BaseModel

from ...package.body.specification import Specification
from ...package.common.plain_data import inputs_sha256
from .beam_schema import BeamBody
from .beams import beam_spec
from .body_schema import ImportedBody, Placed
from .imported import imported_spec
from .reduction import Reducible
from .schema import Mechanism
from .shell_schema import ShellBody
from .shells import shell_body_spec
from .solid_schema import SolidBody
from .solids import solid_body_spec

# Where a body starts, and what a run uses of it, say nothing about its package.
STATE = {*Placed.model_fields, *Reducible.model_fields}


@dataclass(frozen=True)
class BodySpec:
    """What the preprocessor needs to build one flexible body.

    Attributes
    ----------
    content : plain JSON, SI and degrees
    inputs_sha256 : hash of the content
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
    """

    folder: Path
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
        key = (name, own, str(candidates), *(part.model_dump_json() for part in parts))
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
            self._known[key] = BodySpec(content, inputs_sha256(content), tuple(sources))
        return self._known[key]
