"""Write docs/effects.md from the catalogue, or check that it is what the catalogue says today.

python benchmarks/make_effects_page.py            write docs/effects.md
python benchmarks/make_effects_page.py --check    exit status 1 where the page is out of date
"""

from __future__ import annotations

import sys
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from exoid.symbolic.effect import Coefficient, Effect, Shape  # noqa: E402
from exoid.symbolic.effect_catalogue import catalogue, every_effect  # noqa: E402 - the repository must be on the path first
from exoid.symbolic.formula import formula  # noqa: E402
from exoid.symbolic.identifiability import never_separable  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.workbench.commands.effects import joints  # noqa: E402

PAGE = ROOT / "docs" / "effects.md"
HEAD = """\
# The catalogue of physical effects

Written by `python benchmarks/make_effects_page.py`; do not edit. `exoid effects ID` shows one entry.

The torque of an effect is torque that the drive has to supply. θ, θ′, θ″ are angle, velocity and acceleration of the
effect's own joint ([notation](notation.md)). What no motion can distinguish from an effect is computed (exact rank at
random states). Each entry ends with the experiment that tells it from its look-alikes, and its source.
"""
ELSEWHERE = """\

## Other machines

[Chains](machines.md) and [arms in space](machines.md#your-robot) have these as well; "hip" and "knee" stand for two
joints that follow each other.
"""


def page() -> str:
    effects = list(catalogue().values())  # the leg's, then those that only other machines have
    never = never_separable([name for effect in effects for name in names(effect)], Model.standard())
    lines = [HEAD, *overview(effects)]
    cited: dict[str, str] = {}
    for family, members in groupby(effects, key=lambda effect: effect.family):
        lines += ["", f"## {family.capitalize()}"]
        for effect in members:
            lines += ["", *entry(effect, [(n, never[n]) for n in names(effect) if never[n]], cited)]
    lines.append(ELSEWHERE.rstrip())
    for effect in elsewhere(effects):
        lines += ["", *entry(effect, [], cited)]
    return "\n".join(lines) + "\n"


def elsewhere(effects: list[Effect]) -> list[Effect]:
    return [effect for effect in every_effect().values() if effect not in effects]


def overview(effects: list[Effect]) -> list[str]:
    further = elsewhere(effects)
    count = f"{len(effects)} effects of a leg, at either joint unless said"
    lines = [f"{count}, and {len(further)} more of other machines:", ""]
    lines += [f"* [`{e.id}`](#{e.id}): {e.title or e.id}{at(e)}" for e in effects]
    return lines + [f"* [`{e.id}`](#{e.id}): {e.title or e.id} (not on the leg)" for e in further]


def at(effect: Effect) -> str:
    where = joints(effect)
    return "" if where == "hip or knee" else f" ({where})"


def names(effect: Effect) -> list[str]:
    return [effect.id] if effect.on_both else [f"{effect.id}:{joint}" for joint in effect.joints]


def entry(effect: Effect, never: list[tuple[str, tuple[str, ...]]], cited: dict[str, str]) -> list[str]:
    # The heading is the id alone, so that its anchor is the id.
    lines = [f"### {effect.id}", "", effect.explains, ""]
    torques = formula(effect)
    if len(torques) > 1 and len(set(torques.values())) == 1:
        torques = {"hip, and on the knee": next(iter(torques.values()))}
    for joint, text in torques.items():
        where = f" on the {joint}" if joint else ""
        lines.append(f"* Torque{where}: " + (f"`{text}`" if effect.torque else text))
    lines += [f"* Not on the {joint}: {reason}" for joint, reason in effect.absorbed_on.items()]
    lines += [f"* No motion tells `{name}` from {', '.join(f'`{o}`' for o in others)}" for name, others in never]
    lines += [said(name, number) for name, number in {**effect.coefficients, **effect.shape}.items()]
    if effect.tells_apart:
        lines += ["", f"Experiment: {effect.tells_apart}"]
    first = cited.setdefault(effect.reference, effect.id)  # a source is written out once
    source = effect.reference if first == effect.id else f"as for [`{first}`](#{first})"
    return [*lines, "", f"Source: {source}"]


def said(name: str, number: Coefficient | Shape) -> str:
    unit = "" if number.unit == "1" else f" {number.unit}"
    typical = "" if number.typical is None else f", typically {number.typical:g}"
    own = "; each recording has its own" if isinstance(number, Shape) and number.per_recording else ""
    kind = " (shape)" if isinstance(number, Shape) else ""
    return f"* `{name}`{kind}: {number.explains or 'number'}; {span(number)}{typical}{unit}{own}"


def span(number: Coefficient | Shape) -> str:
    if isinstance(number, Shape) and number.choices:
        return " or ".join(f"{choice:g}" for choice in number.choices)
    if number.min is None and number.max is None:
        return "any"
    if number.max is None:
        return f"≥ {number.min:g}"
    return f"≤ {number.max:g}" if number.min is None else f"{number.min:g} to {number.max:g}"


def main() -> int:
    fresh = page()
    if "--check" in sys.argv[1:]:
        current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == fresh
        sys.stdout.write("docs/effects.md is current\n" if current else "docs/effects.md is out of date\n")
        return 0 if current else 1
    PAGE.write_text(fresh, encoding="utf-8")
    sys.stdout.write(f"{PAGE.relative_to(ROOT)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
