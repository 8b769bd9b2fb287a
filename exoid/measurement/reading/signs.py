"""Numbers whose sign the register of a drive holds in a way of its own, put right where the samples leave no doubt.

An unsigned register has its negative numbers at its upper end, or one bit that says the sign. Either leaves numbers at
both ends of two ranges and nothing between, and jumps from one to the other wherever what is measured passes zero; in
what the numbers mean there is none. That shows behind a factor too, as long as the steps of the register do.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.reading.limits import credible
from exoid.symbolic.motion import Float

LEAST_BITS = 8
WIDE = 16
"""Bits from which two ranges at the ends of a register, half of it apart, are nothing else."""
SCALED = (8, 10, 11, 12, 16)
"""Bits of registers that are looked for behind a factor: their steps still show in the digits of a file."""
FINE = sorted(
    2.0**bits * digit * 10.0**power for bits in (WIDE, 24, 32) for power in range(-9, 1) for digit in (1.0, 2.5, 5.0)
)
"""What numbers jump by whose steps are too fine to show: 32 bits of a millionth."""
BOTH: Threshold = 0.02
"""of the samples that each sign has at least: a few codes for an error would be taken for negative numbers"""
LEAST: Threshold = 3
"""times that the sign changes: a single step of what is measured would be taken for one"""
NEAR_ZERO: Threshold = 0.1
"""of the largest number of each sign that the smallest has at most: two levels would be taken for two signs"""
ON_STEPS: Threshold = 0.12
"""of a step, by which numbers behind a factor miss whole steps (root mean square): by chance it is 0.29"""
VARIED: Threshold = 12
"""different numbers at least, behind a factor: few are whole steps of many registers by chance"""
SMOOTH: Threshold = 0.25
"""of either sign's range that it passes zero by, where no step shows: a torque that is switched on and off would be
taken for a register
"""
ALIKE: Threshold = 0.02
"""of half the register, or of a sign's range, that the means of both signs differ by: two levels would be taken for
friction
"""
APART: Threshold = 0.2
"""of the whole, that two ranges are apart at least: noise of one would be taken for jumps to the other"""
DIGITS = 2.5
"""Last digits of the numbers that a step has at least where it is no whole number of them: less is lost in rounding."""
FEW, SOME = 40, 500
"""Different numbers that are asked whether they are whole steps, at first and for certain."""


class Signed(NamedTuple):
    """Numbers (N,) as they are meant, and how their sign was written ("" where it is as it stands); where that is only
    likely, or no `register` is known that is so long, `doubt` says what is seen, and the numbers are as they stand."""

    values: Float
    how: str = ""
    doubt: str = ""
    register: bool = True


class _Register(NamedTuple):
    """A register of so many `bits`, one of which is `step`; `sign` where its highest bit says the sign."""

    bits: int
    step: float = 1.0
    sign: bool = False

    @property
    def half(self) -> float:
        """The first number that means a negative one."""
        return self.step * 2.0 ** (self.bits - 1)

    def meant(self, values: Float) -> Float:
        """Return the values that numbers mean."""
        near = self.half - 0.5 * self.step
        return np.where(values >= near, self.half - values if self.sign else values - 2.0 * self.half, values)

    def __str__(self) -> str:
        if self.sign:
            return f"has its sign in bit {self.bits - 1} (jumps by {self.half:.6g})"
        return f"jumps by {2.0 * self.half:.10g}"


def is_whole(values: Float) -> bool:
    """True if all numbers that are there are whole, and some are."""
    some = values[:: max(1, values.size // 50)]
    with np.errstate(invalid="ignore"):
        return bool(np.all((some == np.round(some)) | np.isnan(some)) and np.isfinite(some).any()) and bool(
            np.all((values == np.round(values)) | np.isnan(values))
        )


def signed(values: Float) -> Signed:
    """Return the numbers (N,) of a column with their sign."""
    good = values[credible(values)]
    if good.size < 10 or good.min() < 0.0:
        return Signed(values)
    top, steps = float(good.max()), np.abs(np.diff(good))
    if not steps.max() > top / 4.0:  # no register is passed through without
        return Signed(values)
    doubt = ""
    for register in _whole_registers(top) if is_whole(good) else _scaled_registers(good, top):
        sure, likely = _fits(good, register)
        if sure:
            return Signed(register.meant(values), str(register))
        doubt = doubt or (f"may be a register of {register.bits} bits ({register})" if likely else "")
    found = Signed(values, "", doubt) if doubt else _ends_apart(good, top)
    if not found.how:
        return found._replace(values=values)
    out = values.copy()
    out[credible(values)] = found.values
    return found._replace(values=out)


def below_zero(values: Float) -> float:
    """Return the span of a register, by which whole numbers (N,) that stay close to the end of a wide one are too
    large, if they are negative ones; 0 where they are not there.
    """
    good = values[credible(values)]
    if good.size < 10 or not is_whole(good) or good.min() <= 0.0:
        return 0.0
    span = 2.0 ** int(good.max()).bit_length()
    return span if span >= 2.0**WIDE and good.min() > 0.75 * span and np.unique(good).size > 2 else 0.0


def continued(values: Float) -> tuple[Float, str]:
    """Return an angle (N,) in whole numbers that ran over the end of its register, and what it jumped by; as it is, and
    "", where it did not.
    """
    good = np.flatnonzero(credible(values))
    if good.size < 10:
        return values, ""
    some = values[good]
    low, high = float(some.min()), float(some.max())
    bits = int(high).bit_length() + (low < 0.0)
    span = 2.0**bits
    first = -span / 2.0 if low < 0.0 else 0.0
    steps = np.diff(some)
    over = np.abs(steps) > 0.75 * span
    ends = low - first < 0.02 * span and first + span - high < 0.02 * span
    if bits < LEAST_BITS or not ends or not over.any() or np.abs(steps[~over]).max(initial=0.0) > span / 4.0:
        return values, ""
    out = values.copy()
    out[good] -= span * np.r_[0.0, np.cumsum(np.sign(steps) * over)]
    return out, f"jumps by {span:.0f}"


def _whole_registers(top: float) -> Iterator[_Register]:
    """Yield the registers that whole numbers up to `top` may come from."""
    bits = int(top).bit_length()
    if bits >= LEAST_BITS:
        yield _Register(bits)
        yield _Register(bits, sign=True)


def _scaled_registers(good: Float, top: float) -> Iterator[_Register]:
    """Yield the registers whose whole steps numbers up to `top` are."""
    many = np.unique(good)
    if many.size < VARIED:
        return
    upper = float(many[np.argmax(np.diff(many)) + 1])
    digit = next((10.0**-k for k in range(10) if np.abs(many * 10.0**k - np.round(many * 10.0**k)).max() < 1e-4), 0.0)
    some, few = (many[np.unique(np.linspace(0, many.size - 1, count).astype(int))] for count in (SOME, FEW))
    for bits in SCALED:
        near = np.arange(1, 2 ** (bits - 2))
        for sign, steps in ((False, top / (2.0**bits - near)), (True, upper / (2.0 ** (bits - 1) + near - 1))):
            steps = steps[_off(few, steps) < ON_STEPS]
            left = _off(some, steps)
            if not steps.size or left.min() >= ON_STEPS:
                continue
            step = float(steps[np.argmin(left)])
            finer = _off(some, step * np.array([2.0, 3.0, 5.0, 7.0])).min() < ON_STEPS  # no step of a register, a part
            finer |= step < DIGITS * digit and abs(step / digit - round(step / digit)) > 1e-6
            if not finer and np.unique(np.round(some / step)).size >= VARIED:
                yield _Register(bits, step, sign)


def _off(numbers: Float, steps: Float) -> Float:
    """Return by what part of each of `steps` (K,) the `numbers` (N,) miss whole ones (root mean square)."""
    ratio = numbers[:, None] / steps
    return np.asarray(np.sqrt(np.mean(np.square(ratio - np.round(ratio)), axis=0)))


def _fits(good: Float, register: _Register) -> tuple[bool, bool]:
    """Flags that numbers certainly come from a register, and whether they are likely to.

    They do where both signs are there and come near zero, every change of sign is a jump over half the register as the
    numbers stand, and none is a jump in what they mean; and where both signs are at the ends of a wide one, or of a
    narrow one and of one size, as friction is.
    """
    half, meant = register.half, register.meant(good)
    negative = meant < 0.0
    sizes = (-meant[negative], meant[~negative])
    if not all(size.size and np.unique(size).size > 2 for size in sizes):
        return False, False
    changes = negative[1:] != negative[:-1]
    jumps, steps = np.abs(np.diff(good))[changes], np.abs(np.diff(meant))
    ends = max(size.max() for size in sizes) < half / 2.0
    usual = _most(steps[~changes], 0.95) if not changes.all() else 0.0
    smooth = bool(_most(jumps, 0.05) > half / 2.0 and _most(steps[changes], 0.995) <= 2.0 * usual + register.step)
    if min(negative.mean(), 1.0 - negative.mean()) < BOTH and not smooth:
        return False, ends and bool(steps[changes].max() < half / 8.0)
    if ends and register.bits >= WIDE and not register.sign:
        return True, True
    through = all(size.min() <= NEAR_ZERO * size.max() for size in sizes)
    passes = through and _most(jumps, 0.05) > half / 2.0 and _most(steps, 0.995) < half / 2.0
    alike = max(size.max() for size in sizes) < 0.75 * half and abs(sizes[0].mean() - sizes[1].mean()) < ALIKE * half
    alike = alike and bool(_most(jumps, 0.05) > half / 2.0)
    sure = (passes and int(changes.sum()) >= LEAST) or (alike and register.bits > LEAST_BITS)
    return sure, alike or (ends and (passes or not register.sign))


def _most(values: Float, share: float) -> float:
    """Return the quantile, of a few values the largest or the smallest."""
    if values.size > 100:
        return float(np.quantile(values, share))
    return float(values.max() if share > 0.5 else values.min())


def _ends_apart(good: Float, top: float) -> Signed:
    """Return numbers with their sign where they are in two ranges, at zero and at `top`, by a span whose steps are too
    fine to show; what is doubted where they go from the end of one to the end of the other, and no such span is known.
    """
    upper = good > 0.5 * top
    changes = upper[1:] != upper[:-1]
    apart = float(good[upper].min() - good[~upper].max()) if changes.any() else 0.0
    if changes.sum() < LEAST or min(upper.mean(), 1.0 - upper.mean()) < BOTH or not apart > APART * top:
        return Signed(good)
    reach = min(float(np.ptp(good[upper])), float(np.ptp(good[~upper])))
    smooth = False
    for meant in (np.where(upper, good - top, good), np.where(upper, good[upper].min() - good, good)):
        smooth |= _most(np.abs(np.diff(meant))[changes], 0.995) < SMOOTH * reach
    span = next((item for item in FINE if top < item < 1.05 * top), 0.0)
    alike = abs(span - good[upper].mean() - good[~upper].mean()) < ALIKE * reach
    near = span - top < SMOOTH * reach
    if span and (alike or (smooth and near)):
        return Signed(np.where(upper, good - span, good), f"jumps by {span:.10g}")
    return Signed(good, "", f"jumps by about {apart:.4g} wherever it passes zero" if smooth else "", register=False)
