"""Names of effects and their numbers in sentences for people; ids stay in tables, files and commands."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence

from exoid.ground.errors import EffectError
from exoid.ground.text import digits
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.effect_catalogue import find_effect

CHOICE = re.compile(r"([+-]?\d+(?:\.\d+)?): ([^,;]+)")
"""A choice in what a shape explains: "+1: at large angles"."""


def title_of(effect: Effect, joint: str | None = None) -> str:
    """Return "Stribeck friction at the knee", without a place for an effect on all joints."""
    title = effect.title or effect.id.replace("_", " ")
    return f"{title} at {the_joint(joint)}" if joint else title


def the_joint(name: str) -> str:
    """The name of a joint in a sentence: "the knee", but "joint_3"."""
    return name if re.search(r"[\d_]", name) else f"the {name}"


def called(name: str, find: Callable[[str], Effect] = find_effect) -> str:
    """Return the title of "stribeck:knee"; the name itself where no effect has it."""
    id, _, joint = name.partition(":")
    try:
        return title_of(find(id), joint or None)
    except EffectError:
        return name


def added_said(label: str, said: Callable[[str], str] = called) -> str:
    """Return "+ Stribeck friction at the hip" of a step "+ stribeck:hip"; of any other step its label."""
    if not label.startswith("+ "):
        return label
    return " ".join(f"+ {said(name)}" for name in label.removeprefix("+ ").split(" + "))


def number_called(effect: Effect, key: str) -> str:
    """Name of one number of an effect: "stiffness of the stop"; its own name where nothing explains it."""
    entry = _entry(effect, key)
    told = "" if entry is None or CHOICE.search(entry.explains) else re.split(r"[;:(,]", entry.explains)[0].strip()
    return told or key


def number_of(name: str) -> str:
    """Return the same of "stribeck:hip.c"; the number's own name where the catalogue has no such effect."""
    term, _, key = name.rpartition(".")
    try:
        return number_called(find_effect(term.partition(":")[0]), key)
    except EffectError:
        return key


def number_said(effect: Effect, key: str, value: float, unit: str, half: float | None = None) -> str:
    """Return "stiffness of the stop 35 ± 2 N·m/rad" or, of a choice, what it stands for: "at large angles"; of a number
    that may be any, that it is not known by itself.
    """
    entry = _entry(effect, key)
    if isinstance(entry, Shape) and entry.choices:
        for number, words in CHOICE.findall(entry.explains):
            if float(number) == round(value, 6):
                return str(words).strip()
    if half == math.inf:
        return f"{number_called(effect, key)} not known by itself"
    spread = f" ± {half:.2g}" if half else ""
    return f"{number_called(effect, key)} {digits(value)}{spread}{'' if unit in ('1', '') else f' {unit}'}"


def _entry(effect: Effect, key: str) -> Coefficient | Shape | None:
    return effect.coefficients.get(key) or effect.shape.get(key)


def per_joint(values: Iterable[float], joints: Sequence[str], unit: str = "N·m") -> str:
    """Return "hip 0.71, knee 0.53 N·m"."""
    return ", ".join(f"{joint} {digits(value)}" for joint, value in zip(joints, values, strict=True)) + f" {unit}"
