"""Causes of the differences between our matrices of the IEA-15-240-RWT blade and those of its file.

    PYTHONPATH=.:benchmarks python benchmarks/blade_trials.py IEA-15-240-RWT.yaml DIR 0.5,0.7,0.9

The lay-up is changed in one respect at a time, and the stations are analysed again. Ours over
theirs: mass, EA, EI flap and edge, GJ, shear stiffness across the webs (flapwise, K33); the
difference of the mass centres in per cent of the chord. Stations are those of the file's matrices.
Needs FEniCSx.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import yaml
from blade_matrices import mass_centre, numbers, theirs

from plymotion.solver.__main__ import main as plymotion
from plymotion.solver.extras.blade.shape import Layer
from plymotion.solver.extras.blade.station import write_station
from plymotion.solver.extras.blade.tables import Along
from plymotion.solver.extras.blade.windio import Blade, read_blade
from plymotion.solver.report.section.codes import read_results

Change = Callable[[Blade], Blade]
R = np.linspace(0.0, 1.0, 401)
EDGE = 0.72  # [m] width of a trailing-edge reinforcement inboard
END = 0.76  # r from which it fades in the file
AROUND = 2.05  # arc of a thin section over its chord
ROUND = 13.0 / 30.0  # of the square of its thickness that an end of a layer lacks, see `rounded`


def layers(blade: Blade, words: str, change: Callable[[Layer], Layer]) -> Blade:
    """The blade with changed layers: those of the shell or of webs whose name has the words."""
    return replace(blade, layers=tuple(change(n) if words in n.name else n for n in blade.layers))


def thicker(words: str, factor: float) -> Change:
    def change(layer: Layer) -> Layer:
        t = layer.thickness
        return replace(layer, thickness=Along(t.grid, factor * t.values))

    return lambda blade: layers(blade, words, change)


def edge(blade: Blade) -> Blade:
    """Reinforcements of the trailing edge at least 1 mm thick, and as wide as inboard."""
    width = np.array([EDGE / (AROUND * blade.chord.at(r)) for r in R])

    def change(layer: Layer) -> Layer:
        thick = Along(R, np.array([max(layer.thickness.at(r), 1e-3) for r in R]))
        start, end = (np.array([arc.at(r) for r in R]) for arc in (layer.start, layer.end))
        out = R > END
        end = np.where(out & (end < 0.5), np.maximum(end, width), end)
        start = np.where(out & (start > 0.5), np.minimum(start, 1.0 - width), start)
        return replace(layer, thickness=thick, start=Along(R, start), end=Along(R, end))

    return layers(blade, "TE_reinforcement", change)


def around(words: str) -> Change:
    """A skin from edge to edge."""
    ends = {key: Along(R[[0, -1]], np.full(2, arc)) for key, arc in (("start", 0.0), ("end", 1.0))}
    return lambda blade: layers(blade, words, lambda layer: replace(layer, **ends))


def webs_moved(blade: Blade) -> Blade:
    """Webs 1 % of the arc nearer to the trailing edge."""

    def moved(arc: Along, by: float) -> Along:
        return Along(arc.grid, arc.values + by)

    webs = (replace(w, start=moved(w.start, -0.01), end=moved(w.end, 0.01)) for w in blade.webs)
    return replace(blade, webs=tuple(webs))


def glue_of_glass(blade: Blade) -> Blade:
    return replace(blade, glue="glass_triax")


def rounded(words: str) -> Change:
    """Ends of layers as the section generator of the matrices rounds them (SONATA, cutoff.py).

    The inner face of a layer of thickness t begins 1.2 t behind its end; a parabola of the control
    points (0, 0), (0.7 t, t), (1.2 t, t) joins both. The area that is missing is 13/30 t^2. Here
    the layer is shorter by 13/30 t.
    """
    return lambda blade: layers(blade, words, partial(_shorter, chord=blade.chord))


def _shorter(layer: Layer, chord: Along) -> Layer:
    if layer.web:
        return layer
    t, start, end, c = (
        np.array([a.at(r) for r in R]) for a in (layer.thickness, layer.start, layer.end, chord)
    )
    cut = np.minimum(ROUND * t / (AROUND * c), 0.45 * (end - start))
    start = np.where(start > 1e-3, start + cut, start)
    end = np.where(end < 1.0 - 1e-3, end - cut, end)
    return replace(layer, start=Along(R, start), end=Along(R, end))


FOAM = [thicker(f"web{k}_filler", 2.0) for k in (0, 1)]
SKINS = [around("Shell_skin")]
TRIALS: dict[str, list[Change]] = {
    "as in the file": [],
    "edge closed by triaxial glass": [glue_of_glass],
    "half of the foam, panels and webs": [thicker("_filler", 0.5)],
    "webs 1 % of the arc aft": [webs_moved],
    "inner skin around the edge (a)": [around("Shell_skin_inner")],
    "reinforcement of the edge (b)": [edge],
    "(a), (b), outer skin around the edge (c)": [edge, *SKINS],
    "ends of caps rounded": [rounded("Spar_Cap")],
    "ends of all layers rounded (d)": [rounded("")],
    "(c) and (d)": [edge, *SKINS, rounded("")],
    "(c), (d), foam of the webs twice": [edge, *SKINS, rounded(""), *FOAM],
}


def main(file: Path, folder: Path, places: list[float]) -> None:
    with file.open(encoding="utf-8") as stream:
        table = yaml.load(stream, Loader=yaml.CSafeLoader)["components"]["blade"]
    grid, K_theirs, M_theirs = theirs(table)
    blade = read_blade(file)
    jobs = []
    for n, (trial, changes) in enumerate(TRIALS.items()):
        changed = blade
        for change in changes:
            changed = change(changed)
        for r in places:
            name = f"t{n:02d}-r{round(1e4 * r):05d}"
            write_station(changed, r, name, folder / "stations")
            jobs.append((trial, r, name))
    listed = folder / "stations" / "stations.txt"
    listed.write_text("".join(f"{name}.toml\n" for *_, name in jobs), encoding="utf-8")
    words = ["section", "--batch", str(listed), "--out", str(folder), "--no-estimate", "--quiet"]
    if plymotion(words):
        raise SystemExit("a section failed")
    for r in places:
        k = int(np.abs(grid - r).argmin())
        print(f"| r = {r:g} | mass | EA | EI flap | EI edge | GJ | K33 | mass centre |")
        print("|---|---|---|---|---|---|---|---|")
        for trial, at, name in jobs:
            if at != r:
                continue
            one = read_results(folder / name / f"{name}.vtkhdf")
            ratios = numbers(one.K, one.M) / numbers(K_theirs[k], M_theirs[k])
            cells = [*ratios, one.K[2, 2] / K_theirs[k][2, 2]]
            shift = (mass_centre(one.M) - mass_centre(M_theirs[k]))[0] / blade.chord.at(r)
            text = " | ".join(f"{x:.3f}" for x in cells)
            print(f"| {trial} | {text} | {100.0 * shift:.1f} % |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), [float(r) for r in sys.argv[3].split(",")])
