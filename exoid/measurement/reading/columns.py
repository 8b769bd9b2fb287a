"""The meaning of a file's columns: usual names (`names.py`), units in the header, and what the user maps by hand.

Two readings that are both possible are a question to the user, never a guess.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from exoid.ground.errors import NoChannelsError, RecordingError
from exoid.ground.suggest import nearest
from exoid.measurement.reading.counts import counts_in, question
from exoid.measurement.reading.likely import counted_joints, likely_option
from exoid.measurement.reading.mapping import DIMENSIONLESS, StatedMapping, listed, mapped, numbered
from exoid.measurement.reading.names import (
    BASE,
    ColumnMeaning,
    is_set_point,
    kind_of,
    quantity_of,
    recognise,
    weak_time,
)
from exoid.measurement.reading.outside import CONTACT, force_columns, outside_columns
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.units import SLIDING, factor, is_product, is_scaled
from exoid.measurement.recording import base_columns
from exoid.symbolic.joints import LEG, MOST, UNNAMED, Joint
from exoid.symbolic.units import QUANTITIES, SI_UNIT, plain_unit

NO_CLOCK = "say how often it was sampled, in Hz: --rate 100 (design: --recorded-rate 100; watch, campaign: a column t)"
TIMELESS = "give every sample its time, in a column t"
"""The same where no rate can be said: of a stream, and of what is joined by its clock."""
LEGS = ("left", "right", "ipsi", "contra")
OF_JOINTS = ("t", "q", "dq", "ddq", "tau", "f")
"""Quantities of a recording that --units may name."""
OTHERS = {a: (b,) for pair in SLIDING.items() for a, b in (pair, pair[::-1])}
"""A quantity of turning joints and the same of sliding ones."""


def required(joints: Sequence[Joint] = LEG) -> tuple[str, ...]:
    """Return the names of the columns that a recording of `joints` must have: t, q1, ..., tau1, ..."""
    numbers = range(1, len(joints) + 1)
    return ("t", *(f"q{k}" for k in numbers), *(f"tau{k}" for k in numbers))


def canonical_columns(joints: Sequence[Joint] = LEG) -> tuple[str, ...]:
    """Return the names of all columns that a recording of `joints` may have."""
    numbers = range(1, len(joints) + 1)
    further = (f"{quantity}{k}" for quantity in ("dq", "ddq", "f") for k in numbers)
    return (*required(joints), *further, *base_columns(joints), *outside_columns(joints))


def spare_columns(joints: Sequence[Joint] = LEG) -> frozenset[str]:
    """Return the names of the columns without which everything can be answered, so that none of them stops reading."""
    own = (f"{quantity}{k + 1}" for quantity in ("dq", "ddq") for k in range(len(joints)))
    return frozenset((*own, *force_columns(joints), CONTACT))


@dataclass(frozen=True)
class Assigned:
    """A canonical column: where it comes from, `factor` to SI, and whether its unit was `told` by
    somebody."""

    name: str
    column: RawColumn
    unit: str
    factor: float
    told: bool


def assign(
    table: RawTable, told: StatedMapping, *, where: str, joints: Sequence[Joint] = LEG, partial: bool = False
) -> dict[str, Assigned]:
    """Return {canonical name: column}; raises RecordingError for a missing, doubtful or doubly used column.

    What is told is as of `assign_usable`.
    """
    found, faults = assign_usable(table, told, where=where, joints=joints, partial=partial, no_clock=TIMELESS)
    for error in faults.values():
        raise error
    return found


def assign_usable(
    table: RawTable,
    told: StatedMapping,
    *,
    where: str,
    joints: Sequence[Joint] = LEG,
    partial: bool = False,
    no_clock: str = NO_CLOCK,
    modelled: bool = True,
) -> tuple[dict[str, Assigned], dict[str, RecordingError]]:
    """Return {canonical name: column} of what can be used, and {canonical name: error} of spare columns that cannot;
    raises RecordingError for any other that is missing, doubtful or used twice.

    What is `told` is {canonical: column in the file}, {quantity, canonical name or column: unit} and the leg ("left",
    "right", "ipsi" or "contra") where the file has several; a joint that is told to be passive needs no torque, which
    is zero. With `partial`, columns may be missing: the rest stands in another file. Unless `modelled`, nobody said
    what the `joints` are, and they were counted.
    """
    mapping, units, leg = _by_number(told.columns, joints), _by_number(told.units, joints), told.leg
    _check_keys(mapping, canonical_columns(joints), "--map", where)
    _check_keys(units, (*OF_JOINTS, *canonical_columns(joints), *table.names), "--units", where)
    chosen = mapped(table, mapping, where)
    if told.rate:
        chosen["t"] = RawColumn("row", np.arange(table.row.shape[0]) / told.rate, "s")
    offers = _offers(table, chosen, units, joints)
    idle = [f"tau{k}" for k, joint in enumerate(joints, start=1) if joint.name in told.passive]
    wanted = [name for name in required(joints) if name not in idle]
    side = _side(offers, chosen, leg, wanted, where)
    hidden: dict[int, str] = {}
    spare = spare_columns(joints)
    for name in canonical_columns(joints):
        if name in chosen:
            continue
        fitting = [offer for offer in offers if offer[0].name == name and offer[0].side in ("", side)]
        if leg and any(reading.side for reading, _ in fitting):
            fitting = [offer for offer in fitting if offer[0].side]
        if not fitting:
            continue
        if name in spare and _differ(fitting):
            continue  # several plates: which one the foot stood on is for the user to say, and `repaired` tells
        reading, column = _best(name, fitting, where)
        chosen[name], hidden[id(column)] = column, reading.unit
    for name in idle:
        chosen.setdefault(name, RawColumn(name, np.zeros(table.row.shape[0])))
    if not partial:
        _check_missing(chosen, table, where, joints, no_clock, modelled, units)
    out: dict[str, Assigned] = {}
    faults: dict[str, RecordingError] = {}
    asked: list[RecordingError] = []
    for name in canonical_columns(joints):
        if name not in chosen:
            continue
        try:
            out[name] = _with_unit(name, chosen[name], units, hidden, where, joints)
        except RecordingError as error:
            if name not in spare or name in mapping or name in units:
                asked.append(error)
            else:
                faults[name] = error
    if asked:
        raise _together(asked)
    return out, faults


def _together(errors: Sequence[RecordingError]) -> RecordingError:
    """Return the first of several errors, its remedy with the options of those that are answered by --units too."""
    first, *others = errors
    found = [re.match(r"--units (\S+)", error.remedy) for error in errors]
    if not others or found[0] is None:
        return first
    options = ",".join(match[1] for match in found if match)
    what = "; ".join(error.what for error, match in zip(errors, found, strict=True) if match)
    return RecordingError(what, where=first.where, remedy=f"--units {options}{first.remedy[found[0].end() :]}")


def inferred(table: RawTable) -> tuple[Joint, ...]:
    """Return the joints of a file that nobody named: as many as it has q1, q2, ... and tau1, tau2, ..., or three and
    more in any other words; else the leg's.

    One joint only where nothing else in the file can be the second's.
    """
    there = {column.name.strip() for column in table.columns}
    count = next(k for k in range(len(there) + 1) if not {f"q{k + 1}", f"tau{k + 1}"} <= there)
    count = count or int({"q", "tau"} <= there)
    meant = {column.name: found.name for column in table.columns if (found := recognise(column.name))}
    if count == 1 and ({"q2", "tau2"} & set(meant.values()) or {"q0", "tau0"} & there):
        return LEG
    named = any(quantity_of(meaning) in ("q", "tau") and not re.search(r"\d", name) for name, meaning in meant.items())
    many = 0 if named else counted_joints(table.names)  # of a leg whose joints are named, numbers count other things
    count = many if many > MANY else count
    if count in (0, 2) or count > MOST:
        return LEG
    return tuple(Joint(f"{UNNAMED}{k + 1}", length=1.0) for k in range(count))


MANY = 2
"""Joints of a leg: more are another machine's."""


def _by_number(given: Mapping[str, str], joints: Sequence[Joint]) -> dict[str, str]:
    """Return `given` with q_hip, tau_knee, ... as q1, tau2, ..."""
    known = {f"{quantity}_{j.name}": f"{quantity}{k}" for quantity in OF_JOINTS for k, j in enumerate(joints, start=1)}
    return {known.get(name, name): value for name, value in given.items()}


Offer = tuple[ColumnMeaning, RawColumn]


def legs(table: RawTable, joints: Sequence[Joint] = LEG) -> tuple[str, ...]:
    """Return the legs of which `table` has every angle and torque, in the order of LEGS."""
    return _complete(_offers(table, {}, {}, joints), {}, required(joints))


def _offers(
    table: RawTable, chosen: Mapping[str, RawColumn], units: Mapping[str, str], joints: Sequence[Joint]
) -> list[Offer]:
    """Return the possible meanings of each column, except of those that are mapped already."""
    taken = {id(column) for column in chosen.values()}
    aliases, doubtful = _counted_from_one(table.names, len(joints))
    offers: list[Offer] = []
    for column in table.columns:
        name = aliases.get(column.name, column.name)
        found = None if id(column) in taken or name in doubtful else _recognised(name, column.unit, tuple(joints))
        if found and quantity_of(found.name) == "i":  # a current is a torque only for whom the constant was given
            name = found.name.replace("i", "tau")
            given = units.get(name) or units.get("tau") or ""
            found = found._replace(name=name) if is_product(given) and re.search(r"A\b", given) else None
        if found:
            offers.append((found._replace(rank=found.rank + 100 * column.rank), column))
    if not any(reading.name == "t" for reading, _ in offers) and "t" not in chosen:
        weak = [c for c in table.columns if weak_time(c.name) and id(c) not in taken and _runs_forwards(c)]
        offers += [(ColumnMeaning("t", rank=50), column) for column in weak[:1]]
    return offers


def _recognised(name: str, unit: str, joints: tuple[Joint, ...]) -> ColumnMeaning | None:
    """Meaning of a column; its unit counts where the name leaves the quantity open: "hip [deg]"."""
    found = recognise(name, joints)
    if found or not unit:
        return found
    found = recognise(f"{name} {unit}", joints)
    return found._replace(unit="") if found and found.unit else None


def _runs_forwards(column: RawColumn) -> bool:
    step = np.diff(column.values[np.isfinite(column.values)])
    return bool(step.size > 10 and np.mean(step > 0) > 0.95)


def _complete(offers: Sequence[Offer], chosen: Mapping[str, RawColumn], wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the legs of which every column of `wanted` is there, counting columns that name no leg."""
    there = {(reading.side, reading.name) for reading, _ in offers}
    sides = {side for side, _ in there if side}
    return tuple(
        side
        for side in LEGS
        if side in sides and all(n in chosen or ("", n) in there or (side, n) in there for n in wanted)
    )


def _side(
    offers: Sequence[Offer], chosen: Mapping[str, RawColumn], leg: str, wanted: Sequence[str], where: str
) -> str:
    """Return the leg to read ("" where the columns name none); asks where more than one is possible."""
    sides = {reading.side for reading, _ in offers if reading.side and reading.name in wanted}
    if leg:
        if leg in sides or not sides:
            return leg
        if len(sides) == 1 and sides <= {"ipsi"} and leg != "contra":
            return "ipsi"
        what = f"there are no columns of the {leg} leg, only of: {', '.join(s for s in LEGS if s in sides)}"
        remedy = f"--leg {next(s for s in LEGS if s in sides)}, or name the columns with --map q1=COLUMN"
        raise RecordingError(what, where=where, remedy=remedy)
    unsided = {reading.name for reading, _ in offers if not reading.side}
    if not sides or all(name in chosen or name in unsided for name in wanted):
        return ""
    whole = _complete(offers, chosen, wanted)
    possible = whole or tuple(side for side in LEGS if side in sides)
    if len(possible) > 1:
        both = " or --leg both (two recordings)" if set(possible) == {"left", "right"} and whole else ""
        what = f"the file holds columns of more than one leg ({', '.join(possible)}): which is it?"
        raise RecordingError(what, where=where, remedy=f"--leg {' or --leg '.join(possible)}{both}")
    return possible[0]


def _differ(offers: Sequence[Offer]) -> bool:
    """True if the best of the offers are several columns that are not the same."""
    fewest = min(reading.rank for reading, _ in offers)
    first, *others = (column for reading, column in offers if reading.rank == fewest)
    return any(not _same(first, other) for other in others)


def _best(name: str, offers: Sequence[Offer], where: str) -> Offer:
    """Return the offer of smallest rank; asks where two of them differ."""
    fewest = min(reading.rank for reading, _ in offers)
    best = [offer for offer in offers if offer[0].rank == fewest]
    first = best[0][1]
    # Time series of Simulink each carry the same time.
    alike = _same_clock if name == "t" else _same
    if any(not alike(first, other) for _, other in best[1:]):
        names = numbered([column.name for _, column in best])
        what = f"more than one column can be {name}: {', '.join(repr(n) for n in names)}"
        raise RecordingError(what, where=where, remedy=f"say which: --map {name}={names[0]}")
    return best[0]


def _same(one: RawColumn, other: RawColumn) -> bool:
    return np.array_equal(one.values, other.values, equal_nan=True)


def _same_clock(one: RawColumn, other: RawColumn) -> bool:
    """True if two columns are one clock, counted from another instant or in a thousandth or so of its unit.

    Signals that were logged each with a time of its own (`q1.Time`, `tau1.Time`) do not share rows, so they must agree.
    """
    if _same(one, other):
        return True
    if re.search(r"[./]", one.name + other.name):
        return False
    good = np.isfinite(one.values) & np.isfinite(other.values)
    if good.sum() < 10 or good.mean() < 0.9:
        return False
    a, b = (c.values[good] - c.values[good][0] for c in (one, other))
    if not (a[-1] > 0 and b[-1] > 0):
        return False
    ratio = 10.0 ** (3 * round(np.log10(b[-1] / a[-1]) / 3))
    return bool(np.abs(b - ratio * a).max() < 0.02 * ratio * np.median(np.abs(np.diff(a))))


def _check_keys(given: Mapping[str, str], known: Sequence[str], option: str, where: str) -> None:
    for key in given:
        if key not in known:
            close = nearest(key, known, 1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            what = f"{option} names {key!r}, which is not a column exoid knows"
            raise RecordingError(what, where=where, remedy=f"{hint}known: {', '.join(known)}")


def _check_missing(
    chosen: Mapping[str, RawColumn], table: RawTable, where: str, joints: Sequence[Joint], no_clock: str,
    modelled: bool, units: Mapping[str, str],
) -> None:
    missing = [name for name in required(joints) if name not in chosen]
    if not missing:
        return
    nothing = len(missing) >= 2 * len(joints) and not any(quantity_of(name) in ("q", "tau") for name in chosen)
    error = NoChannelsError if nothing else RecordingError
    seen_there = f"columns found: {listed(table.names)}"
    seen_there += f"; no columns of numbers: {listed(table.others, 8)}" if table.others else ""

    def counted(columns: Mapping[str, RawColumn]) -> tuple[str, str]:
        """The --units of counts among columns, which would be asked for next, and what they are."""
        plain = {
            name: column
            for name, column in columns.items()
            if not {name, quantity_of(name), column.name} & set(units) and not column.unit
        }
        found = counts_in({n: c for n, c in plain.items() if not _hidden(c.name, n, tuple(joints))}, joints)
        asked = question(found, joints) if found else None
        return (asked.units, asked.notes) if asked else ("", "")

    if len(joints) > MANY and not modelled:
        what = f"the file has {len(joints)} joints ({seen_there}), and no model says what machine that is"
        remedy = "give its model first: --model FILE, a URDF or what exoid model writes; in Python joints=model.joints"
        raise error(what, where=where, remedy=remedy)
    aliases, _ = _counted_from_one(table.names, len(joints))
    seen = ((recognise(aliases.get(name, name), tuple(joints)), name) for name in table.names)
    currents = {found: name for found, name in seen if found and quantity_of(found.name) == "i"}
    torques = [name for name in missing if quantity_of(name) == "tau"]
    if torques and torques == missing and currents:
        shown = ", ".join(repr(name) for name in list(currents.values())[:4])
        amperes = ",".join(f"{name}=Nm/A*0.1*50" for name in torques)
        counts, notes = counted(chosen)
        raise RecordingError(
            f"no column for {', '.join(missing)} was found, but currents: {shown}",
            where=where,
            remedy="say what one ampere is at the joint, torque constant times gear: "
            f"--units {','.join(filter(None, (amperes, counts)))} {notes or 'with your numbers'}",
        )
    idle = [joints[int(name.removeprefix("tau")) - 1].name for name in torques]
    used = {id(column) for column in chosen.values()}
    names = numbered(table.names)
    free = [replace(c, name=n) for c, n in zip(table.columns, names, strict=True) if id(c) not in used]
    clock = chosen["t"].values if "t" in chosen else None
    option, all_found, likely = likely_option(missing, free, clock, joints)
    counts, notes = counted({**chosen, **likely}) if all_found else ("", "")
    option += f" --units {counts}" if counts else ""
    alone = torques == missing and len(idle) == 1 and "--passive" not in option
    drive = f"; --passive {idle[0]} where that joint has no drive" if alone else ""
    absent = {f"{quantity}{k}" for k in range(1, len(joints) + 1) for quantity in ("q", "tau")} - set(chosen)
    other = any(name.replace("q", "tau") in absent for name in absent if quantity_of(name) == "q") and joints is LEG
    drive += "; a machine of other joints needs its model: --model FILE, in Python Model(joints=[...])" if other else ""
    what = f"no column for {', '.join(missing)} was found ({seen_there})"
    if missing == ["t"]:
        what = f"no time column was found ({seen_there})"
        raise RecordingError(what, where=where, remedy=f"{no_clock}; or --map t=COLUMN")
    asked_for = [name for name in table.names if is_set_point(name, tuple(joints))]
    if asked_for and not all_found and "=" not in option.replace("=COLUMN", ""):
        what = f"no column for {', '.join(missing)} was found, only set-points: {listed(asked_for, 8)} ({seen_there})"
        remedy = "log what was measured: a set-point is what the machine was asked for, and not what it did"
        raise error(what, where=where, remedy=remedy)
    numbers = f" {notes}" if notes else ""
    remedy = (f"did you mean {option}{numbers}?" if all_found else f"say which column it is: {option}") + drive
    raise error(what, where=where, remedy=remedy)


def _counted_from_one(names: Sequence[str], count: int) -> tuple[dict[str, str], set[str]]:
    """Return {name: the same counted from 1} for `count` joints counted from 0, and the names that count 0, 1, 2, ...
    further.

    Of these nobody can say which are meant.
    """
    out: dict[str, str] = {}
    doubtful: set[str] = set()
    for name in names:
        found = re.fullmatch(r"(.*?)(?<!\d)0(\D*)", name)
        if not found:
            continue
        counted = [f"{found[1]}{k}{found[2]}" for k in range(count + 1)]
        there = sum(item in names for item in counted)
        if there == count and counted[-1] not in names:
            out |= dict(pairwise(counted))
        elif counted[1] in names and count > 1:
            doubtful |= {f"{found[1]}{k}{found[2]}" for k in range(100)}
    return out, doubtful


def _with_unit(
    name: str,
    column: RawColumn,
    units: Mapping[str, str],
    hidden: Mapping[int, str],
    where: str,
    joints: Sequence[Joint],
) -> Assigned:
    quantity = kind_of(name, joints)
    of_all = units.get(quantity if name in BASE else quantity_of(name), "")  # --units q=deg is meant for every angle
    mixed = len({joint.turns for joint in joints}) > 1
    if mixed and factor(quantity, of_all) is None and any(factor(k, of_all) for k in OTHERS.get(quantity, ())):
        of_all = ""  # --units q=deg is not meant for the joint that slides
    told = units.get(name) or units.get(column.name) or of_all
    si = SI_UNIT[quantity]
    written = column.unit or hidden.get(id(column), "") or _hidden(column.name, name, tuple(joints))
    unit = told or written
    if unit in DIMENSIONLESS:
        return Assigned(name, column, si, 1.0, False)
    scale = factor(quantity, unit, written)
    plain = si.replace("·", "")
    if scale is None and (is_scaled(quantity, unit) or (written == unit and "*" in unit)):
        number, meaning = _further(unit)
        raise RecordingError(
            f"column {column.name!r} ({name}) is in {unit}, which becomes {si} only with a further number",
            where=where,
            remedy=f"--units {name}={unit}*{number} with your numbers: {meaning}"
            if "*" not in unit
            else f"--units {name}={plain}*0.5 with what one {unit} is",
        )
    if scale is None and is_product(unit) and written and factor(quantity, unit) is not None:
        what = f"{name}={unit} does not fit column {column.name!r}, which the file says is in {written}"
        raise RecordingError(what, where=where, remedy=f"write the factor for one {written}")
    if scale is None:
        what = f"unit {unit!r} of column {column.name!r} ({name}) is not known"
        remedy = f"--units {name}={_proposed(quantity, unit, column)} if it is so; "
        remedy += f"known: {', '.join(QUANTITIES[quantity])}"
        raise RecordingError(what, where=where, remedy=remedy)
    if quantity == "t" and scale < 0.0:
        what = f"time counts backwards in {unit!r}: every velocity would change its sign"
        remedy = "give a unit without a minus; where the clock counts down, write a column that counts up"
        raise RecordingError(what, where=where, remedy=remedy)
    return Assigned(name, column, unit, scale, True)


LIKELY: Mapping[str, tuple[float, str, str]] = {
    "t": (0.5, "s", "ms"), "q": (4 * np.pi, "rad", "deg"), "dq": (50.0, "rad/s", "deg/s"), "tau": (1000.0, "Nm", "mNm"),
    "x": (20.0, "m", "mm"), "dx": (20.0, "m/s", "mm/s"),
}  # fmt: skip
"""How far numbers go in SI, of a clock by how much in a step, and the unit that they are likely in beyond."""


def _proposed(quantity: str, unit: str, column: RawColumn) -> str:
    """Return the unit that one nobody knows may be: one misspelt by a letter, if the numbers do not go too far."""
    most, plain, large = LIKELY.get(quantity, (np.inf, SI_UNIT[quantity].replace("·", ""), ""))
    good = column.values[np.isfinite(column.values)]
    size = np.abs(np.diff(good) if quantity == "t" else good)
    far = bool(size.size and np.percentile(size, 50 if quantity == "t" else 98) > most)
    alike = nearest(plain_unit(unit), QUANTITIES[quantity], 1, cutoff=0.8)
    close = alike[0] if alike and alike[0][0] == plain_unit(unit)[:1] else ""
    if close and not (far and QUANTITIES[quantity][close] >= 1.0):
        return close
    return large if far else plain


def _hidden(text: str, name: str, joints: tuple[Joint, ...]) -> str:
    """Return the unit at the end of the name of a column that was mapped by hand to what it says: "timestamp_ms"."""
    found = recognise(text, joints)
    return found.unit if found and found.name == name else ""


def _further(unit: str) -> tuple[str, str]:
    """Return an example of the number that turns `unit` into SI, and what it is."""
    below = unit.rpartition("/")[2].strip().lower()
    if below in ("a", "ma"):
        return "0.1*50", "torque constant times gear ratio"
    if below == "kg":
        return "75", "the body mass in kg"
    return ("45", "the rated torque at the joint") if below in "%‰" else ("0.5", "the gain")
