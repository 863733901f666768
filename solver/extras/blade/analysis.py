"""A blade from its file to its table: stations are meshed, analysed, compared and written."""

import logging
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...inputs.case.record import CASE_FILE
from ...math.laws import lengths_along
from ...package.common.files import refuse_foreign, write_text
from .layers import StationMesh, with_face
from .operation import AERO, OPERATION, POLARS, read_rotor, write_rotor
from .shape import contour
from .station import bands_of, webs_of, write_station
from .stations import (
    Station,
    analysed,
    body_csv,
    complete,
    line_of,
    station_csv,
    write_for,
)
from .turbine import BLADED, ROTOR_CASE, TOWER, Machine, write_blade_case, write_turbine
from .windio import Blade, differences, read_blade

LOGGER = logging.getLogger(__name__)
REMOVED = 0.02  # share of the layers' area without room, above which a warning says so
WHOLE = 0.02  # between the masses of a blade and of its file, above which a warning says so
TABLE, BODY = "blade.csv", "beam.csv"
OF_ROTOR = (AERO, POLARS, OPERATION, ROTOR_CASE, TOWER, BLADED)


@dataclass(frozen=True)
class Meshed:
    """Meshes and descriptions of stations in a folder.

    Attributes
    ----------
    places : r of 0 to 1 by name of the station, also of those that have failed
    meshes : by name of the station
    failed : why a station has no mesh, by its name
    """

    blade: Blade
    folder: Path
    places: dict[str, float]
    meshes: dict[str, StationMesh] = field(default_factory=dict)
    failed: dict[str, Exception] = field(default_factory=dict)

    @property
    def descriptions(self) -> list[Path]:
        """Section descriptions of the stations that have a mesh."""
        return [self.folder / "stations" / f"{name}.toml" for name in self.meshes]

    @property
    def sections(self) -> Path:
        """Folder of the section files, folder/NAME/NAME.vtkhdf."""
        return self.folder / "sections"


def folder_of(file: Path) -> Path:
    """Return build/blades/NAME, the folder of a windIO file. Raises InputError: no name."""
    if file.stem in (".", ".."):
        raise InputError(f"{file}: expected a file with a name before its ending")
    return Path("build") / "blades" / file.stem


def read_and_mesh(
    file: Path,
    folder: Path,
    *,
    count: int | None = None,
    at: Sequence[float] = (),
    rotor: bool = False,
    failed: Callable[[str, float, Exception], None],
) -> Meshed:
    """Read a windIO file and write folder/stations: a mesh and a description of each station.

    Findings are logged as warnings.

    Parameters
    ----------
    count : stations at equal distances from root to tip
    at : places r of 0 to 1; neither: the grid of the file's chord
    rotor : the file must have what `write_whole` needs for its rotor
    failed : called with each station that cannot be meshed; the others are

    Raises
    ------
    InputError : the file is wrong, both `count` and `at`, stations at one place, foreign files.
    """
    blade = read_blade(file)
    if rotor:
        Machine(blade, read_rotor(blade)[0])
    for text in blade.left_out:
        _warning("not-modelled", f"{file}: {text}")
    for text in blade.doubtful:
        _warning("unlike-a-blade", f"{file}: {text}")
    for text in blade.differences:
        _warning("rule-differs", f"{file}: {text}")
    if at and count:
        raise InputError("blade: expected --stations or --at, not both")
    if count:
        at = np.linspace(0.0, 1.0, count).tolist()
    places = at or np.unique(np.clip(blade.span, 0.0, 1.0)).tolist()
    meshed = Meshed(blade, folder, {f"r{round(1e4 * r):05d}": r for r in places})
    if len(meshed.places) < len(places):
        raise InputError("blade: stations closer than 1e-4 of the span")
    for written in (TABLE, BODY, CASE_FILE, *(OF_ROTOR if rotor else ())):
        refuse_foreign(folder / written)  # before the work
    for name, r in meshed.places.items():
        try:
            mesh = write_station(blade, r, name, folder / "stations")
        except (InputError, ValueError, ArithmeticError, LookupError) as error:
            meshed.failed[name] = error  # the others can be right
            failed(name, r, error)
            continue
        meshed.meshes[name] = mesh
        if mesh.removed > REMOVED:
            text = "of the layers find no room between the two sides and are not there"
            _warning("no-room", f"station r = {r:g}: {mesh.removed:.1%} {text}")
    return meshed


def collected(meshed: Meshed, failed: Container[str]) -> list[Station]:
    """Read the section files, compare them with the matrices of the file and write blade.csv.

    Parameters
    ----------
    failed : names of stations whose analysis has failed; their files are of earlier calls
    """
    blade, stations = meshed.blade, analysed(meshed.sections, meshed.places, meshed.meshes, failed)
    for station in complete(stations):
        if blade.given is not None and station.results is not None:
            deviations = differences(blade.given, station.r, station.results)
            place = f"{blade.file}: station r = {station.r:g}"
            if deviations:
                _warning("differs-from-file", f"{place}: {'; '.join(deviations)}")
    _compare_masses(blade, complete(stations))
    write_text(meshed.folder / TABLE, station_csv(blade, stations))
    return stations


def _compare_masses(blade: Blade, stations: Sequence[Station]) -> None:
    """Warn of stations from root to tip whose mass is not that of the file [kg]."""
    r = [station.r for station in stations]
    if blade.given is None or not {0.0, 1.0} <= set(r):
        return
    s = lengths_along(line_of(blade, r))
    theirs = [blade.given.at(x).get("mass", np.nan) for x in r]
    sums = [one.results.M[0, 0] for one in stations if one.results], theirs, thin_masses(blade, r)
    own, known, thin = (float(np.trapezoid(row, s)) for row in sums)
    if abs(own / known - 1.0) > WHOLE:
        text = f"{own:.5g} kg, elastic_properties {known:.5g} kg (x {own / known:.3f}); thickness"
        text += f" times arc of the outer surface, as thin-walled codes count, {thin:.5g} kg"
        _warning("differs-from-file", f"{blade.file}: the blade has {text} (x {thin / known:.3f})")


def thin_masses(blade: Blade, places: Sequence[float]) -> list[float]:
    """Thickness times arc of the outer surface, and webs between its points, at r [kg/m]."""
    masses, rho = [], {name: material["rho"] for name, material in blade.materials.items()}
    for r in places:
        bands = bands_of(blade, r)
        points, _ = with_face(contour(blade, r), bands)
        s = lengths_along(points)
        mass = s[-1] * sum(rho[b.material] * b.thickness * (b.end - b.start) for b in bands)
        for web in webs_of(blade, r):
            ends = np.array([web.start, web.end]) * s[-1]
            height = np.hypot(*(np.diff(np.interp(ends, s, x))[0] for x in points.T))
            mass += height * sum(rho[b.material] * b.thickness for b in web.layers)
        masses.append(float(mass))
    return masses


def write_whole(
    meshed: Meshed,
    stations: Sequence[Station],
    code: str | None,
    *,
    rotor: bool = False,
    controller: Sequence[Path] = (),
) -> list[Path]:
    """Write what needs all stations: the beam body, its case, files for another code.

    Parameters
    ----------
    code : "beamdyn" or "hawc2"; None: no files for another code
    rotor : also its strips and polars in the wind, and its steady operation
    controller : of that rotor, see `write_turbine`

    Raises
    ------
    InputError : a station is missing, or the other code needs more of them.
    """
    done = complete(stations)
    if len(done) < len(meshed.places):
        analysed = {station.name for station in done}
        lost = ", ".join(f"{r:g}" for name, r in meshed.places.items() if name not in analysed)
        raise InputError(f"blade: r = {lost}: without these stations the blade is another one")
    write_text(meshed.folder / BODY, body_csv(meshed.blade, stations))
    files = [meshed.folder / BODY]
    files += write_for(code, meshed.blade, stations, meshed.folder) if code else []
    if len(done) > 1:
        files.append(write_blade_case(meshed.blade, stations, meshed.folder))
    if rotor:
        written, strips, wind, points = write_rotor(meshed.blade, meshed.folder)
        files += written
        if len(done) > 1:
            turbine = meshed.blade, stations, strips, wind, points, meshed.folder
            files += write_turbine(*turbine, controller)
    return files


def _warning(code: str, text: str) -> None:
    LOGGER.warning("warning [%s] %s", code, text)
