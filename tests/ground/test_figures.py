"""Figures look the same whatever matplotlib was told in the user's settings."""

from __future__ import annotations

import matplotlib as mpl

from exoid.ground.figures import (
    JOINT_COLOURS,
    ROLE_COLOURS,
    colour_rules,
    figure_style,
    joint_colours,
    new_figure,
    plain_power,
    to_svg,
)


def drawn() -> str:
    with figure_style():
        figure = new_figure(3.0, 2.0)
        axes = figure.subplots()
        axes.plot([-1.0, 2.0], [0.0, 1.0], label="$x_1")
        axes.legend()
    return to_svg(figure)


def test_the_users_matplotlibrc_changes_no_figure():
    usual = drawn()
    with mpl.rc_context():
        mpl.rcParams.update({"text.usetex": True, "axes.unicode_minus": False, "path.sketch": (1, 100, 2)})
        mpl.rcParams.update({"savefig.bbox": "tight", "figure.figsize": (20, 1), "lines.marker": "x"})
        assert drawn() == usual
        assert mpl.rcParams["text.usetex"]  # theirs, outside


def test_powers_on_a_logarithmic_axis_are_text_and_names_are_not_parsed():
    with figure_style():
        figure = new_figure(3.0, 2.0)
        axes = figure.subplots()
        axes.semilogy([1, 2], [1e-8, 1e4], label="$x.csv")
        axes.legend()
    to_svg(figure)
    shown = [tick.get_text() for tick in axes.get_yticklabels()]
    assert "10⁻⁵" in shown and not any("$" in text for text in shown)
    assert plain_power(r"$\mathdefault{2\times10^{-3}}$") == "2·10⁻³" and plain_power("$x.csv") == "$x.csv"


def test_pages_and_figures_have_their_colours_from_one_place():
    rules = colour_rules()
    for j, colour in enumerate(joint_colours(["hip", "knee", "ankle"]).values()):
        assert f"--j{j}:{colour};" in rules and f".joint-{j}{{--joint:var(--j{j})}}" in rules
    assert f"--model:{ROLE_COLOURS['model']};" in rules and f"--after:{ROLE_COLOURS['after']};" in rules
    assert not set(ROLE_COLOURS.values()) & {light for light, _ in JOINT_COLOURS}
