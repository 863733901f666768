"""A cross-section in Python: stiffness, mass, centres, a small picture of its plies."""

from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.inputs.section.specification import BUILD
from ..solver.inputs.section.study import described_spec
from ..solver.math.arrays import Array
from ..solver.package.common.plain_data import data_sha256, plain
from ..solver.package.common.recovery_schema import CORNERS, RESULTANTS
from ..solver.package.section.section_file import read_section
from ..solver.package.section.section_schema import SectionFile, SectionMeshData
from ..solver.report.section.codes import SectionResults, read_results
from ..solver.workers.description_results import Entry, made_file
from .result import named
from .signal import Markup, pandas, table

MOST_CELLS = 6000  # of a picture that a notebook keeps
SIZE = 260  # pixels
# Okabe and Ito, as the figures of reports
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00")


def picture(mesh: SectionMeshData) -> Markup:
    """Return the cells of a section as SVG, coloured by ply; nothing for a very fine mesh."""
    cells = len(mesh.cell_types)
    if cells > MOST_CELLS:
        return Markup("")
    nodes = mesh.nodes
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    scale = (SIZE - 8) / float(np.max(high - low) or 1.0)
    x = 4 + (nodes[:, 0] - low[0]) * scale
    y = 4 + (high[1] - nodes[:, 1]) * scale
    paths: dict[int, list[str]] = {}
    for c in range(cells):
        first = int(mesh.offsets[c])
        corners = mesh.connectivity[first : first + CORNERS[int(mesh.cell_types[c])]]
        points = "L".join(f"{x[i]:.1f} {y[i]:.1f}" for i in corners)
        paths.setdefault(int(mesh.ply[c]), []).append(f"M{points}Z")
    parts = [
        f'<path d="{"".join(path)}" fill="{COLOURS[ply % len(COLOURS)]}" stroke="white" '
        'stroke-width="0.2"/>'
        for ply, path in sorted(paths.items())
    ]
    height = 8 + float(high[1] - low[1]) * scale
    return Markup(f'<svg width="{SIZE}" height="{height:.0f}">{"".join(parts)}</svg>')


class Section:
    """An analysed cross-section.

    Axes x1 along the beam, (x2, x3) in the section (docs/conventions.md). Order of rows and
    columns: F1, F2, F3, M1, M2, M3.

    Attributes
    ----------
    file : path of the section file

    Examples
    --------
    >>> import plymotion as pm
    >>> section = pm.Section.from_file("bar.vtkhdf")
    >>> section
    <Section bar: EA 8.4e+07 N, GJ 4424 N m2, EI 2800 and 2.52e+04 N m2, 3.24 kg/m>
    >>> section.K.shape, section.M.shape
    ((6, 6), (6, 6))
    """

    def __init__(self, file: str | Path) -> None:
        self.file = Path(file)
        self._results: SectionResults = read_results(self.file)

    @classmethod
    def from_file(
        cls,
        file: str | Path,
        changes: Mapping[str, Any] | None = None,
        *,
        derivatives: Iterable[str] | Mapping[str, Mapping[str, float]] = (),
        out: str | Path = BUILD,
        force: bool = False,
    ) -> "Section":
        """Return the section of a description (TOML), analysed unless that is up to date, or of a
        section file (.vtkhdf).

        The analysis needs FEniCSx; a section file does not.

        Parameters
        ----------
        changes : other values at dotted keys of the description:
            {"laminates.wall.angles_deg.1": 30.0}
        derivatives : dotted keys of numbers of the description by which everything is
            differentiated, or names of parameters, each with the factors of several keys:
            {"skew": {"laminates.wall.angles_deg.0": 1.0, "laminates.wall.angles_deg.1": -1.0}}
        out : folder of section files
        force : analyse what is up to date

        Raises
        ------
        InputError
            A mistake in the description, one line each; an analysis that fails.
        PackageError
            Not a section file.

        >>> import plymotion as pm
        >>> f'{pm.Section.from_file("bar.vtkhdf").K[0, 0]:.4g}'
        '8.4e+07'
        """
        path = Path(file)
        if path.suffix == ".vtkhdf":
            return cls(path)
        own, folder = plain(changes or {}), Path(out)
        asked = (
            derivatives if isinstance(derivatives, Mapping) else {k: {k: 1.0} for k in derivatives}
        )
        made_of = {**own, "derivatives": plain(asked)} if asked else own
        name = f"{path.stem}-{data_sha256(made_of)[:8]}" if made_of else path.stem

        def spec_of(entry: Entry) -> dict[str, object]:
            return described_spec(entry.file, own, name, folder, asked)

        with named(None if folder == BUILD else folder):
            return cls(made_file(Entry(name, path, own), "section", spec_of, folder, force=force))

    @property
    def name(self) -> str:
        """Name of the section.

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").name
        'bar'
        """
        return self._results.name

    @property
    def K(self) -> Array:
        """Stiffness (6, 6) [N, N m, N m2].

        >>> import plymotion as pm
        >>> bool(abs(pm.Section.from_file("bar.vtkhdf").K[0, 3]) < 1e-9)
        True
        """
        return self._results.K

    @property
    def M(self) -> Array:
        """Mass per length (6, 6) [kg/m, kg, kg m].

        >>> import plymotion as pm
        >>> f'{pm.Section.from_file("bar.vtkhdf").M[0, 0]:.4g}'
        '3.24'
        """
        return self._results.M

    @property
    def shear_centre(self) -> Array:
        """Shear centre (2,) x2, x3 [m].

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").shear_centre.shape
        (2,)
        """
        return self._results.shear_centre

    @property
    def tension_centre(self) -> Array:
        """Tension centre (2,) x2, x3 [m].

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").tension_centre.shape
        (2,)
        """
        return self._results.tension_centre

    @property
    def mass_centre(self) -> Array:
        """Mass centre (2,) x2, x3 [m].

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").mass_centre.shape
        (2,)
        """
        return self._results.mass_centre

    @property
    def derivatives(self) -> dict[str, dict[str, Array]]:
        """Derivatives by each parameter, by path in the section file; absent: zero.

        Paths are "K", "M", "shear_centre", "recovery/strain_M" and others (docs/section-file.md),
        units those of the dataset per unit of the parameter.

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").derivatives
        {}
        """
        return {one.name: one.values for one in self._results.design}

    @property
    def error(self) -> float | None:
        """Largest estimated error of K, in units of sqrt(Kii Kjj) [-]; None: not estimated.

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").error < 1e-2
        True
        """
        return self._results.worst_error

    @property
    def warnings(self) -> list[dict[str, str]]:
        """Warnings with `code` and `message` (docs/warnings.md).

        >>> import plymotion as pm
        >>> [warning["code"] for warning in pm.Section.from_file("bar.vtkhdf").warnings]
        ['sharp-corner']
        """
        return list(self._results.warnings)

    @cached_property
    def data(self) -> SectionFile:
        """The whole section file: mesh, warping, recovery of stresses.

        >>> import plymotion as pm
        >>> pm.Section.from_file("bar.vtkhdf").data.mesh.nodes.shape[1]
        2
        """
        return read_section(self.file)

    def to_pandas(self) -> Any:
        """Return K as a DataFrame. Raises ImportError without pandas.

        >>> import plymotion as pm
        >>> K = pm.Section.from_file("bar.vtkhdf").to_pandas()
        >>> round(float(K.loc["F1", "F1"]), -3)
        84000000.0
        """
        pd = pandas()
        return pd.DataFrame(self.K, index=RESULTANTS, columns=RESULTANTS)

    def __repr__(self) -> str:
        K, mass = self.K, self.M[0, 0]
        return (
            f"<Section {self.name}: EA {K[0, 0]:.4g} N, GJ {K[3, 3]:.4g} N m2, "
            f"EI {K[4, 4]:.4g} and {K[5, 5]:.4g} N m2, {mass:.4g} kg/m>"
        )

    def _repr_html_(self) -> str:
        rows = [[name, *map(float, row)] for name, row in zip(RESULTANTS, self.K, strict=True)]
        return table(["K", *RESULTANTS], rows, repr(self).strip("<>")) + picture(self.data.mesh)


section = Section.from_file
