"""Numbers across devices: a random-effects model per parameter, and the devices that stand out.

Every job gives a parameter with its 95 % interval; jobs of one device are combined first, then the devices: estimate
y_i = μ + u_i + e_i with e_i of the known variance of the device and u_i of variance τ² between devices (Paule and
Mandel 1982, as `statsmodels.stats.meta_analysis.combine_effects` fits it). A device stands out where its distance from
the mean of all the others is more than the spread of the others explains, at 5 % over all devices (Holm).
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from exoid.apps.campaign.plan import Plan
from exoid.ground.plain import AsJson

LEAST_DEVICES = 3
"""Devices below which a spread between them cannot be distinguished from the spread within."""
LEAST_FOR_OUTLIERS = 4
LEVEL = 0.05
Z = 1.959963984540054


@dataclass(frozen=True)
class Outlier(AsJson):
    """A device whose `value` is `distance` standard deviations from the mean of the others; `p` after Holm."""

    device: str
    value: float
    distance: float
    p: float


@dataclass(frozen=True)
class Pooled(AsJson):
    """A parameter over `devices`: `mean` with its 95 % interval, `spread` (τ, standard deviation between devices)."""

    parameter: str
    unit: str
    devices: int
    mean: float
    low: float
    high: float
    spread: float
    outliers: tuple[Outlier, ...] = ()


def pool(plan: Plan, rows: Sequence[Mapping[str, Any]]) -> list[Pooled]:
    """Return every parameter that enough devices have, pooled; empty without a device field or without statsmodels."""
    if plan.device is None or not has_statsmodels():
        return []
    values: dict[str, dict[str, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
    units: dict[str, str] = {}
    for row in rows:
        device = row["fields"].get(plan.device, "")
        for name, item in ((row.get("result") or {}).get("parameters") or {}).items():
            variance = _variance(item)
            if variance is not None:
                values[name][device].append((item["value"], variance))
                units[name] = item.get("unit", "")
    return [_pooled(name, units[name], found) for name, found in values.items() if len(found) >= LEAST_DEVICES]


def has_statsmodels() -> bool:
    """True if the library of the random-effects model is installed."""
    import importlib.util

    return importlib.util.find_spec("statsmodels") is not None


def pooled_mean(values: Iterable[tuple[float, float]]) -> tuple[float, float, float]:
    """Return mean, its variance and τ² of (value, variance) pairs; a single pair is its own mean."""
    pairs = list(values)
    if len(pairs) == 1:
        return (*pairs[0], 0.0)
    import numpy as np
    from statsmodels.stats.meta_analysis import combine_effects

    effects, variances = np.array(pairs).T
    scale = max(float(np.sqrt(np.mean(effects**2))), float(np.sqrt(variances.max())), 1e-300)
    with np.errstate(divide="ignore", invalid="ignore"):  # devices that agree exactly
        found = combine_effects(effects / scale, variances / scale**2, method_re="iterated", use_t=False)
    return float(found.mean_effect_re) * scale, float(found.var_eff_w_re) * scale**2, float(found.tau2) * scale**2


def _pooled(name: str, unit: str, found: Mapping[str, list[tuple[float, float]]]) -> Pooled:
    devices = {device: pooled_mean(values)[:2] for device, values in sorted(found.items())}
    mean, variance, tau2 = pooled_mean(devices.values())
    half = Z * math.sqrt(variance)
    return Pooled(
        name, unit, len(devices), mean, mean - half, mean + half, math.sqrt(max(tau2, 0.0)), _outliers(devices)
    )


def _outliers(devices: Mapping[str, tuple[float, float]]) -> tuple[Outlier, ...]:
    if len(devices) < LEAST_FOR_OUTLIERS:
        return ()
    from scipy.stats import t

    from exoid.optimisation.contest.runtime import holm

    raw = []
    for device, (value, variance) in devices.items():
        others = [pair for name, pair in devices.items() if name != device]
        mean, error, tau2 = pooled_mean(others)
        total = variance + error + max(tau2, 0.0)
        distance = (value - mean) / math.sqrt(total)
        # Degrees of freedom by Satterthwaite (1946): what is estimated is τ² among the others, beside what they report.
        estimated = (max(tau2, 0.0) + sum(v for _, v in others) / len(others)) * (1.0 + 1.0 / len(others))
        freedom = (len(others) - 1) * max(total / estimated, 1.0) ** 2
        raw.append((device, value, distance, 2.0 * float(t.sf(abs(distance), freedom))))
    corrected = holm([p for *_, p in raw])
    found = (
        Outlier(device, value, distance, p)
        for (device, value, distance, _), p in zip(raw, corrected, strict=True)
    )
    return tuple(sorted((item for item in found if item.p < LEVEL), key=lambda one: one.p))


def _variance(one: Mapping[str, Any]) -> float | None:
    numbers = [one.get(key) for key in ("value", "low", "high")]
    if any(not isinstance(n, (int, float)) or not math.isfinite(n) for n in numbers):
        return None
    _, low, high = (float(n) for n in numbers if n is not None)
    return ((high - low) / (2.0 * Z)) ** 2 if high > low else None
