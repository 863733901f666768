"""Stresses and margins of the plies under given resultants, as text for the screen."""

from collections.abc import Mapping, Sequence

from ...package.section.schema import RESULTANTS, STRESSES
from .ply_peaks import PlyPeak, Reserve, weakest


def load_text(
    peaks: Sequence[PlyPeak], F: Sequence[float], warnings: Sequence[Mapping[str, str]] = ()
) -> str:
    """Return the highest stress of every ply under resultants F, its smallest margins, warnings."""
    loads = ", ".join(
        f"{name} = {value:g} {'N' if name[0] == 'F' else 'N m'}"
        for name, value in zip(RESULTANTS, F, strict=True)
    )
    columns = [f"s{name}" for name in STRESSES]
    width = max([len("region"), *(len(_ply(peak)) for peak in peaks)])
    head = f"{'ply':{width}}{'angle':>7}" + "".join(f"{name:>11}" for name in columns)
    lines = [
        "Stresses of largest magnitude in each ply [MPa], in its axes, under",
        loads,
        head,
        *(
            f"{_ply(peak):{width}}{peak.ply.angle_deg:7.4g}"
            + "".join(f"{value:11.4g}" for value in peak.stress_M / 1e6)
            for peak in peaks
        ),
    ]
    doubts = [f"warning [{w['code']}] {w['message']}" for w in warnings]
    return "\n".join([*lines, "", *_margins(peaks, width), *doubts])


def _ply(peak: PlyPeak) -> str:
    return f"{peak.ply.region} {peak.ply.index + 1} {peak.ply.material}"


def _margins(peaks: Sequence[PlyPeak], width: int) -> list[str]:
    without = sorted({peak.ply.material for peak in peaks if not peak.reserves})
    lines = [f"No margins for {', '.join(without)}: no strengths are given"] if without else []
    least = weakest(peaks)
    if not least:
        return lines
    lines += [
        "Margins of safety: load factor at failure minus 1",
        f"{'ply':{width}}{'angle':>7}" + "".join(f"{name:>14}" for name in least),
    ]
    for peak in peaks:
        if peak.reserves:
            cells = "".join(f"{_margin(peak.reserves.get(name)):>14}" for name in least)
            lines.append(f"{_ply(peak):{width}}{peak.ply.angle_deg:7.4g}{cells}")
    for name, worst in least.items():
        reserve = worst.reserves[name]
        x2, x3 = reserve.point
        lines.append(
            f"least by {name}: {reserve.ratio - 1.0:.3g} in {_ply(worst)} "
            f"({reserve.mode}) at x2 = {x2:.4g} m, x3 = {x3:.4g} m"
        )
    return lines


def _margin(reserve: Reserve | None) -> str:
    return "-" if reserve is None else f"{reserve.ratio - 1.0:.3g}"
