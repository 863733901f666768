"""A rotor blade in Python: sections of its stations, its table as a beam, its frequencies."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import InputError, few
from ..solver.extras.blade.analysis import (
    TABLE,
    Meshed,
    collected,
    folder_of,
    read_and_mesh,
    write_whole,
)
from ..solver.extras.blade.stations import Station, frequencies_at_rest
from ..solver.inputs.case.record import CASE_FILE
from ..solver.inputs.section.study import described_spec
from ..solver.math.arrays import Array
from ..solver.system.platform import cores
from ..solver.workers.description_results import Entry, made_files
from ..solver.workers.launch import keep_preprocessors
from .result import named
from .section import Section
from .signal import pandas


class Blade:
    """An analysed rotor blade; `blade` returns it.

    Axes of a section: x2 from the reference axis to the leading edge along the chord, x3 to the
    suction side, x1 to the tip (docs/blade.md). Order of rows and columns: F1, F2, F3, M1, M2, M3.

    Attributes
    ----------
    folder : of the files that `plymotion blade` writes as well

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.blade("blade.yaml", stations=3)  # doctest: +SKIP
    <Blade blade: 61.5 m, 3 stations>
    """

    def __init__(self, meshed: Meshed, stations: Sequence[Station]) -> None:
        self._meshed, self._stations = meshed, stations
        self.folder = meshed.folder

    @property
    def case(self) -> Path:
        """Case of the blade on its turning hub, for `plymotion.load`.

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.blade("blade.yaml", stations=3).case.name  # doctest: +SKIP
        'case.toml'
        """
        return self.folder / CASE_FILE

    @property
    def r(self) -> Array:
        """Stations (n,), from 0 at the root to 1 at the tip [-].

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.blade("blade.yaml", stations=3).r  # doctest: +SKIP
        array([0. , 0.5, 1. ])
        """
        return np.array([station.r for station in self._stations])

    @property
    def sections(self) -> list[Section]:
        """The analysed section of each station.

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.blade("blade.yaml", stations=3).sections[0].K.shape  # doctest: +SKIP
        (6, 6)
        """
        return [Section(station.file) for station in self._stations]

    @property
    def K(self) -> Array:
        """Stiffness about the reference axis, without twist (n, 6, 6) [N, N m, N m2].

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.blade("blade.yaml", stations=3).K.shape  # doctest: +SKIP
        (3, 6, 6)
        """
        return np.array([s.results.K for s in self._stations if s.results is not None])

    @property
    def M(self) -> Array:
        """Mass per length about the reference axis, without twist (n, 6, 6) [kg/m, kg, kg m].

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.blade("blade.yaml", stations=3).M.shape  # doctest: +SKIP
        (3, 6, 6)
        """
        return np.array([s.results.M for s in self._stations if s.results is not None])

    def frequencies(self) -> tuple[Array, dict[str, Array]]:
        """Return the six lowest frequencies at rest, clamped at the root, and their errors.

        Returns
        -------
        frequencies : (6,) [Hz]
        errors : (6,) [-] by cause: "sections", "stations", "elements"; not those without estimate

        Examples
        --------
        >>> import plymotion as pm
        >>> f, errors = pm.blade("blade.yaml").frequencies()  # doctest: +SKIP
        >>> f.shape  # doctest: +SKIP
        (6,)
        """
        return frequencies_at_rest(self._meshed.blade, self._stations)

    def to_pandas(self) -> Any:
        """Return blade.csv as a DataFrame. Raises ImportError without pandas.

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.blade("blade.yaml", stations=3).to_pandas().shape[0]  # doctest: +SKIP
        3
        """
        return pandas().read_csv(self.folder / TABLE)

    def __repr__(self) -> str:
        name, n = self._meshed.blade.file.stem, len(self._stations)
        length = float(np.ptp(self._meshed.blade.length.values))
        return f"<Blade {name}: {length:.4g} m, {n} stations>"


def blade(
    path: str | Path,
    *,
    stations: int | None = None,
    at: Sequence[float] = (),
    out: str | Path | None = None,
    to: str | None = None,
    estimate: bool = True,
) -> Blade:
    """Analyse the cross-sections of a rotor blade from a windIO 2 file.

    Stations that are up to date are read. Doubtful data of the file are warnings of the logger
    "plymotion". Needs FEniCSx and PyYAML.

    Parameters
    ----------
    path : the windIO file
    stations : number of stations at equal distances from root to tip
    at : places of stations from 0 to 1; neither: the grid of the chord in the file
    out : folder of the files, those of `plymotion blade`; None: build/blades/NAME
    to : "beamdyn" or "hawc2": also files for this code
    estimate : estimate the error of each section, which takes three times as long

    Raises
    ------
    InputError
        The file is wrong, a station cannot be analysed, a file would be replaced.

    Examples
    --------
    >>> import plymotion as pm
    >>> one = pm.blade("blade.yaml", stations=3, estimate=False)  # doctest: +SKIP
    >>> one.K.shape  # doctest: +SKIP
    (3, 6, 6)
    """
    if to not in (None, "beamdyn", "hawc2"):
        raise InputError(f"to = {to!r}: expected beamdyn or hawc2")
    file = Path(path)
    folder = Path(out) if out is not None else folder_of(file)

    def failed(name: str, r: float, error: Exception) -> None:
        raise error

    with named(None if out is None else folder):
        meshed = read_and_mesh(file, folder, count=stations, at=at, failed=failed)
        entries = [Entry(description.stem, description) for description in meshed.descriptions]
        keep_preprocessors()
        made = made_files(
            entries,
            "section",
            [] if estimate else ["--no-estimate"],
            lambda entry: described_spec(entry.file, {}, entry.name, meshed.sections),
            meshed.sections,
            jobs=cores(),
        )
        if errors := [one.error for one in made if one.status == "failed"]:
            raise InputError(few(errors))
        analysed = collected(meshed, ())
        write_whole(meshed, analysed, to)
    return Blade(meshed, analysed)
