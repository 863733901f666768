"""One station of a blade: its mesh and its section description."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from ...errors import InputError, nearest
from ...package.common.temporary import write_text
from ...package.common.toml_text import toml_text
from .cells import StationMesh
from .contour import contour
from .materials import GLUE
from .mesh import station_mesh
from .shape import Layer
from .wall import Band, WebLayers
from .windio import Blade, region_name

THIN = 1e-4  # [m] layers below are not there: files write them where a layer ends
EDGE = "trailing-edge"  # region of the plate that closes a sharp trailing edge
PLATE = 0.004  # its thickness over the chord


def write_station(blade: Blade, r: float, name: str, folder: Path) -> StationMesh:
    """Write folder/name.msh and folder/name.toml of the station at r of 0 to 1.

    Raises
    ------
    InputError : the station has no layers, an unknown material, or webs whose feet overlap.
    """
    shell = [layer for layer in blade.layers if not layer.web and _is_there(layer, r)]
    bands = [band for layer in shell for band in _parts(layer, r)]
    if not bands:
        raise InputError(f"{blade.file}: no layer of the shell at r = {r:g}")
    webs = [
        WebLayers(
            web.name,
            web.start.at(r),
            web.end.at(r),
            tuple(_band(n, r) for n in blade.layers if n.web == web.name and _is_there(n, r)),
        )
        for web in blade.webs
        if web.start.covers(r) and web.end.covers(r)
    ]
    edge = Band(EDGE, _glue(blade, bands), 0.0, PLATE * blade.chord.at(r), 0.0, 1.0)
    try:
        mesh = station_mesh(contour(blade, r), bands, [web for web in webs if web.layers], edge)
    except InputError as error:
        raise InputError(f"{blade.file}: station r = {r:g}: {error}") from error
    for band in mesh.bands.values():
        if band.material not in blade.materials:
            hint = nearest(band.material, blade.materials)
            raise InputError(
                f"{blade.file}: layer {band.name}: no material {band.material!r}{hint}"
            )
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / f"{name}.msh", _msh(mesh))
    write_text(folder / f"{name}.toml", _description(blade, r, name, mesh))
    return mesh


def _is_there(layer: Layer, r: float) -> bool:
    """Files give layers that do not reach from root to tip on a part of the grid only."""
    span = layer.end.at(r) - layer.start.at(r) + _wraps(layer, r)
    there = layer.thickness.covers(r) and (
        bool(layer.web) or (layer.start.covers(r) and layer.end.covers(r))
    )
    return there and layer.thickness.at(r) > THIN and (bool(layer.web) or span > 1e-3)


def _wraps(layer: Layer, r: float) -> bool:
    """True if a layer goes around the trailing edge: it begins on the pressure side."""
    return layer.start.at(r) > 0.5 > layer.end.at(r)


def _parts(layer: Layer, r: float) -> list[Band]:
    """A layer of the shell as bands; one around the trailing edge as two."""
    band = _band(layer, r)
    if not _wraps(layer, r):
        return [band]
    both = replace(band, end=1.0), replace(band, name=f"{band.name}-suction", start=0.0)
    return [part for part in both if part.end - part.start > 1e-3]


def _glue(blade: Blade, bands: list[Band]) -> str:
    """Material of the plate: that of the file's adhesive, or of the innermost layer at the edge.

    Files have a "resin" whose stiffness is a placeholder (1 MPa); with it, the section is open.
    """
    named = [name for name in blade.materials if GLUE in name.lower()]
    behind = [band.material for band in bands if band.start <= 0.0]
    return blade.glue or next(iter([*named, *reversed(behind), bands[-1].material]))


def _band(layer: Layer, r: float) -> Band:
    start, end = max(layer.start.at(r), 0.0), min(layer.end.at(r), 1.0)
    return Band(
        region_name(layer.name),
        layer.material,
        layer.angle.at(r),
        layer.thickness.at(r),
        start,
        end,
    )


def _msh(mesh: StationMesh) -> str:
    """The mesh in gmsh's format 2.2."""
    names = list(mesh.bands)
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
    lines.append('1 1 "outer"')
    lines += [f'2 {number + 2} "{name}"' for number, name in enumerate(names)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(mesh.nodes))]
    lines += [f"{k + 1} {x!r} {y!r} 0" for k, (x, y) in enumerate(mesh.nodes)]
    lines += ["$EndNodes", "$Elements", str(len(mesh.outer) + len(mesh.cells))]
    number = 0
    for edge in mesh.outer:
        number += 1
        lines.append(f"{number} 1 2 1 1 " + " ".join(str(k + 1) for k in edge))
    for cell, region in zip(mesh.cells, mesh.regions, strict=True):
        number += 1
        kind, tag = (2 if len(cell) == 3 else 3), names.index(region) + 2
        lines.append(f"{number} {kind} 2 {tag} {tag} " + " ".join(str(k + 1) for k in cell))
    return "\n".join([*lines, "$EndElements", ""])


def _description(blade: Blade, r: float, name: str, mesh: StationMesh) -> str:
    regions: dict[str, dict[str, Any]] = {}
    for region, band in mesh.bands.items():
        regions[region] = {"material": band.material}
        if blade.materials[band.material]["kind"] == "orthotropic":
            vector = mesh.directions.get(region)
            direction = {"curve": "outer"} if vector is None else {"vector": list(vector)}
            regions[region] |= {"angle_deg": band.angle_deg, "direction": direction}
    used = sorted({band.material for band in mesh.bands.values()})
    table = {
        "format": 1,
        "title": f"{blade.file.stem}, r = {r:g}",
        **({"convention": "contour"} if any(b.angle_deg for b in mesh.bands.values()) else {}),
        "mesh": {"file": f"{name}.msh"},
        "materials": {material: blade.materials[material] for material in used},
        "regions": regions,
    }
    remarks = (
        f"# Station r = {r:g}, written by `plymotion blade`.\n"
        "# x2 to the leading edge, x3 to the suction side, origin on the reference axis.\n\n"
    )
    return remarks + toml_text(table)
