"""One look for all figures: colours that everyone can distinguish, units on every axis, no global state.

    with figure_style():
        figure = new_figure(width=7, height=4)
        axes = figure.subplots()
        axes.plot(t, tau, color=joint_colours(["hip", "knee"])["hip"])
        axes.set(xlabel=label("time", "s"), ylabel=label("torque", "N·m"))

Colours: Okabe and Ito, "Color Universal Design", 2008. A figure is a plain `matplotlib.figure.Figure` that
pyplot does not know, so that nothing leaks when a report draws a hundred of them.
"""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import cycle
from types import MappingProxyType
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OKABE_ITO: Mapping[str, str] = MappingProxyType(
    {
        "blue": "#0072b2",
        "vermilion": "#d55e00",
        "green": "#009e73",
        "orange": "#e69f00",
        "sky": "#56b4e9",
        "purple": "#cc79a7",
        "yellow": "#f0e442",
    }
)
"""The eight colours of Okabe and Ito without black, which is `INK`."""

INK, FAINT, GRID, PAPER = "#1c2128", "#6a737d", "#d8dee4", "#ffffff"
"""Text and axes, second-rate text, grid lines, background. A report in dark mode exchanges exactly these."""

JOINT_COLOURS = (
    ("#6b4fa0", "#b8a1e6"), ("#b04c00", "#f08c4a"), ("#9a4f7f", "#e29cc4"),
    ("#7a5200", "#e3b341"), ("#2f6f7e", "#7fc4d4"), ("#5b6472", "#aab4c0"),
)  # fmt: skip
"""Colours of the first, second, ... joint of a machine, each in light and in dark mode; the seventh has the first."""

LINE_STYLES = ("-", "--", "-.", ":")
"""Of the first, second, ... joint, for black-and-white prints."""


def joint_colours(joints: Sequence[str]) -> dict[str, str]:
    """Colour of each joint of a machine by its name."""
    return {joint: light for joint, (light, _) in zip(joints, cycle(JOINT_COLOURS), strict=False)}


ROLES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {"measured": (FAINT, "#9da7b3"), "model": ("#0072b2", "#4aa3df"), "after": ("#00724f", "#3fb98b")}
)
"""What a line is -> its colour in light and in dark mode. The error has the colour of the model that makes it."""

ROLE_COLOURS: Mapping[str, str] = MappingProxyType({role: light for role, (light, _) in ROLES.items()})


def colour_rules() -> str:
    """CSS with the colours of roles (`--model`) and joints (`.joint-0`), light and dark, for every page."""
    named = {**ROLES, **{f"j{j}": pair for j, pair in enumerate(JOINT_COLOURS)}}
    light, dark = ("".join(f"--{name}:{pair[mode]};" for name, pair in named.items()) for mode in (0, 1))
    count = len(JOINT_COLOURS)
    joints = "".join(f".joint-{j}{{--joint:var(--j{j % count})}}" for j in range(2 * count))
    screen = "@media screen and (prefers-color-scheme:dark)"
    return f":root{{{light}--joint:var(--accent)}}\n{screen}{{:root{{{dark}}}}}\n{joints}\n"

LARGEST_SVG = 700_000
"""Bytes. A figure with more points than that is embedded as PNG instead."""


@contextmanager
def figure_style() -> Iterator[None]:
    """Apply the style to everything drawn inside the `with` block, and to nothing outside it."""
    import matplotlib as mpl
    from cycler import cycler

    settings: Any = {
        "axes.axisbelow": True,
        "axes.edgecolor": FAINT,
        "axes.facecolor": PAPER,
        "axes.grid": True,
        "axes.labelcolor": INK,
        "axes.prop_cycle": cycler(color=list(OKABE_ITO.values())[:6]),
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlecolor": INK,
        "axes.titlelocation": "left",
        "axes.titlesize": 11,
        "axes.titleweight": "bold",
        "figure.constrained_layout.use": True,
        "figure.dpi": 110,
        "figure.facecolor": PAPER,
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib: the same picture on every machine
        "font.size": 10,
        "grid.color": GRID,
        "grid.linewidth": 0.7,
        "legend.frameon": False,
        "legend.labelcolor": INK,
        "lines.linewidth": 1.4,
        "savefig.facecolor": PAPER,
        "svg.fonttype": "path",
        "svg.hashsalt": "exoid",  # the same figure gives the same bytes
        "text.color": INK,
        "text.parse_math": False,  # a file may be called $x.csv
        "xtick.color": FAINT,
        "xtick.labelcolor": INK,
        "ytick.color": FAINT,
        "ytick.labelcolor": INK,
    }
    with mpl.rc_context():
        mpl.rcdefaults()  # and nothing of the matplotlibrc of the user or the folder (text.usetex, say)
        mpl.rcParams.update(settings)
        yield


def new_figure(width: float = 7.0, height: float = 4.0) -> Figure:
    """Return an empty figure of `width` × `height` inches that leaves room for its labels."""
    with figure_style():
        return _figure_type()(figsize=(width, height), layout="constrained")


@cache
def _figure_type() -> type[Figure]:
    """Return the type of our figures, which write powers on logarithmic axes as text: nothing in them is parsed."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogFormatterMathtext

    class PlainPowers(LogFormatterMathtext):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return plain_power(super().__call__(x, pos))

    def plain(given: Any) -> Any:
        """The same formatter, with powers as text; None where it writes none, or does so already."""
        if not isinstance(given, LogFormatterMathtext) or isinstance(given, PlainPowers):
            return None
        made = PlainPowers()
        vars(made).update(vars(given))
        return made

    class PlainFigure(Figure):
        def draw(self, renderer: Any) -> None:
            for axis in (axis for axes in self.axes for axis in (axes.xaxis, axes.yaxis)):
                if (major := plain(axis.get_major_formatter())) is not None:
                    axis.set_major_formatter(major)
                if (minor := plain(axis.get_minor_formatter())) is not None:
                    axis.set_minor_formatter(minor)
            super().draw(renderer)

    return PlainFigure


def plain_power(text: str) -> str:
    """Return a power in matplotlib's markup as text: 10⁻⁸ for "$\\mathdefault{10^{-8}}$"."""
    inner = re.fullmatch(r"\$\\mathdefault\{(.*)\}\$", text)
    if inner is None:
        return text
    raised = re.sub(r"\^\{(.*?)\}", lambda power: power[1].translate(RAISED), inner[1])
    return raised.replace(r"\times", "·")


RAISED = str.maketrans("0123456789-−.", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻·")


def label(quantity: str, unit: str = "") -> str:
    """Return the text of an axis: "torque [N·m]", or "share" for a pure number."""
    return f"{quantity} [{unit}]" if unit else quantity


def to_svg(figure: Figure) -> str:
    """Return `figure` as SVG text; the same figure gives the same text."""
    buffer = io.StringIO()
    with figure_style():
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def to_png(figure: Figure, dpi: int = 150) -> bytes:
    """Return `figure` as PNG bytes."""
    buffer = io.BytesIO()
    with figure_style():
        figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def to_data_uri(figure: Figure, largest: int = LARGEST_SVG, dpi: int = 150) -> str:
    """Return `figure` as a data URI for an `<img>`: SVG that follows the reader's light or dark mode, or PNG
    where the SVG would be larger than `largest`.
    """
    svg = adaptive(_light(to_svg(figure)))
    if len(svg) <= largest:
        return SVG_URI + quote(svg, safe=PLAIN)  # a quarter less than in base64
    return png_uri(to_png(figure, dpi))


def png_uri(png: bytes) -> str:
    """Return the bytes of a PNG as a data URI."""
    return PNG_URI + base64.b64encode(png).decode("ascii")


def png_of_uri(uri: str) -> bytes:
    """Return the PNG that `png_uri` made a data URI of."""
    return base64.b64decode(uri.removeprefix(PNG_URI))


PNG_URI, SVG_URI = "data:image/png;base64,", "data:image/svg+xml,"
PLAIN = " =:/;,+!?*@$[]{}|^`"
"""What needs no escape in a data URI within quotation marks; brackets do, or a reader would look for url(...)."""


def _light(svg: str) -> str:
    """Return `svg` with its curves to a hundredth of a point, and without indentation."""
    svg = re.sub(r'(?<= d=")[^"]+', lambda found: re.sub(r"\d+\.\d+", lambda x: f"{float(x[0]):.2f}", found[0]), svg)
    return re.sub(r"\s*\n\s*", " ", svg)


def to_uris(figure: Figure) -> tuple[str, str]:
    """Return the data URI of `figure` and the one of its PNG. Room for its labels is made once: half of the work."""
    uri = to_data_uri(figure)
    engine = figure.get_layout_engine()
    figure.set_layout_engine("none")
    try:
        return uri, uri if uri.startswith(PNG_URI) else png_uri(to_png(figure))
    finally:
        figure.set_layout_engine(engine)


DARK: Mapping[str, str] = MappingProxyType(
    {
        INK: "#e6edf3",
        FAINT: "#9da7b3",
        GRID: "#30363d",
        PAPER: "#161b22",
        **dict(ROLES.values()),
        **dict(JOINT_COLOURS),
    }
)
"""Colour in light mode -> the same colour in dark mode, where the contrast would suffer."""


def adaptive(svg: str) -> str:
    """Return `svg` with the colours of `DARK` exchanged when its reader prefers a dark page."""
    for index, light in enumerate(DARK):
        svg = re.sub(rf"(?<=: ){light}(?=[;\"\s])", f"var(--c{index})", svg)
    light_rules = "".join(f"--c{index}:{light};" for index, light in enumerate(DARK))
    dark_rules = "".join(f"--c{index}:{dark};" for index, dark in enumerate(DARK.values()))
    style = f"<style>:root{{{light_rules}}}@media (prefers-color-scheme:dark){{:root{{{dark_rules}}}}}</style>"
    start = svg.index(">", svg.index("<svg")) + 1
    return svg[:start] + style + svg[start:]
