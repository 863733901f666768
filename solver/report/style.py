"""Style of all figures: colours for colour-blind readers, thin axes, clear text."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..package.common.files import temporary_sibling
from ..system.interrupts import deferred

# Palette of Okabe and Ito without yellow, which is too light for lines.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), "-.")  # for print in black and white
INK, GREY, PALE = "#222222", "#777777", "#C9C9C9"
WARNING = "#B00020"

# Entries of a file that would differ from run to run, by its format.
_UNSAID = {"png": ["Software"], "svg": ["Date"], "pdf": ["CreationDate", "Creator", "Producer"]}
_RULES: Any = {
    "svg.hashsalt": "plymotion",  # names within an SVG that do not change
    "pdf.fonttype": 42,  # text that can be edited and searched
    "font.size": 9,
    "font.family": "DejaVu Sans",
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "axes.formatter.limits": (-3, 4),
    "figure.dpi": 150,
}


@contextlib.contextmanager
def house_style(*, formulas: bool = False) -> Iterator[None]:
    """Context with the style of all figures. Raises InputError without matplotlib.

    With `formulas`, text between dollar signs is one; names of a user then need `plain_words`.
    """
    try:
        with deferred():
            import matplotlib
            import matplotlib.backends.backend_agg
            import matplotlib.figure
    except ImportError as error:
        raise InputError(
            "report: figures need matplotlib, which is not installed; expected "
            "`pip install matplotlib`"
        ) from error
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # without matplotlibrc of the current folder, which can start LaTeX
        matplotlib.rcParams.update({**_RULES, "text.parse_math": formulas})
        yield


def plain_words(text: str) -> str:
    """Return words of a user for a figure with formulas."""
    return text.replace("$", r"\$")


class Canvas:
    """A matplotlib figure without pyplot and its global state; use it inside house_style()."""

    def __init__(self, width: float, height: float) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(self.figure)

    def panels(self, rows: int, columns: int = 1, **options: Any) -> list[Any]:
        """Return axes, row by row.

        Parameters
        ----------
        rows : number of rows
        columns : number of columns
        options : options of matplotlib's `subplots`
        """
        return list(self.figure.subplots(rows, columns, squeeze=False, **options).ravel())

    def save(self, path: Path, *, own: bool = False) -> Path:
        """Write a PNG, SVG or PDF, by the suffix, under a temporary name, then rename it.

        `own` replaces a file of others too: scripts of benchmarks/ draw pictures of the pages.
        """
        from matplotlib.ticker import LogFormatter, LogFormatterSciNotation

        for axis in (axis for a in self.figure.axes for axis in (a.xaxis, a.yaxis)):
            # powers of ten as 1e-06: house_style() switches formulas off
            if isinstance(axis.get_major_formatter(), LogFormatterSciNotation):
                axis.set_major_formatter(LogFormatter())
                axis.set_minor_formatter(LogFormatter(minor_thresholds=(0.5, 0.4)))
        # Saved with a layout engine, a figure is laid out twice and drawn twice.
        engine = self.figure.get_layout_engine()
        if engine is not None:
            engine.execute(self.figure)
            self.figure.set_layout_engine(None)
        with temporary_sibling(path, own=own) as temporary:
            # Without creation tool and date, the same run gives the same bytes.
            form = path.suffix[1:]
            self.figure.savefig(temporary, format=form, metadata=dict.fromkeys(_UNSAID[form]))
        return path


def colour(index: int) -> str:
    """Return the colour of the index-th series."""
    return COLOURS[index % len(COLOURS)]


def unit_text(unit: str) -> str:
    """Return " [m]" for an axis label; a quotient has "[-]"."""
    return f" [{unit}]" if unit else ""


def mark_stop(axes: Any, t: float, t_full: float, *, label: bool = True) -> None:
    """Mark the end of a run that stopped before the others.

    Parameters
    ----------
    axes : axes of matplotlib
    t : end of the run [s]
    t_full : end of the longest run [s]
    label : with a text
    """
    axes.axvline(t, color=WARNING, linewidth=1.0, linestyle=(0, (3, 2)), zorder=1)
    if label:
        side, ha = (4, "left") if t < 0.6 * t_full else (-4, "right")
        box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
        where = (t, 1.0), (side, -3), ("data", "axes fraction"), "offset points"
        style = {"color": WARNING, "fontsize": 8, "bbox": box}
        axes.annotate(f"stopped at {t:.4g} s", *where, ha=ha, va="top", **style)
