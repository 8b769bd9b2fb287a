"""Loads of which only the link is known: weighed and placed by the recordings without them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.own_numbers.fits import Fits
from exoid.diagnosis.own_numbers.found import placed
from exoid.diagnosis.own_numbers.numbers import Belonging, with_numbers
from exoid.diagnosis.own_numbers.state import Claimed
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.errors import NotEnoughDataError
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.mechanics.payload import PayloadError
from exoid.symbolic.model import Model

WITHOUT = "give what is known of it: FILE=KG@M"


def with_loads_weighed(
    model: Model,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    links: Mapping[int, str],
    rules: Rules = RULES,
    **filtering: Any,
) -> tuple[tuple[Recording, ...], tuple[Recording, ...], tuple[Belonging, ...]]:
    """Return recordings and held-out ones with the loads on `links`, {index, held-out ones last: link}, and what is
    said of them; `filtering` are `cutoff` and `derivative` of `prepare`.

    A load is a small body on the axis of its link, as `Payload`. PayloadError where a link carries none that can be, or
    no recording is without; NotEnoughDataError where its mass cannot be told from nothing.
    """
    every = (*recordings, *verify)
    if len(links) == len(every):
        what = "every recording carries an unknown load, and a machine that always carries it is another machine"
        raise PayloadError(what, where="--payload", remedy="give a recording without a load, too")
    prepared = prepare(model, recordings, verify, **filtering)
    now = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    fits = Fits(now, rules, {})
    state = []
    for k, link in links.items():
        known = {claim.place: claim for claim in fits.claims if claim.what == "carried_load"}
        whole = known.get(list(known)[-1] if known and link == "shank" and link not in known else link)
        if whole is None:
            what = f"nobody finds a load on {link!r} of this machine"
            remedy = f"its links are {', '.join(map(str, known))}" if known else WITHOUT
            raise PayloadError(what, where=f"--payload {every[k].name}={link}", remedy=remedy)
        claim = replace(whole, shared=True)  # each load has a mass and a place of its own
        fits.place[claim] = fits.place[whole]
        state.append(Claimed(claim, claim.nodes[0], ((k,),)))
    held = placed(fits, tuple(state))
    if not np.isfinite(fits.loss(held)):
        what = "no mass on that link asks for the torques of these recordings"
        names = ", ".join(every[k].name for k in links)
        raise PayloadError(what, where=f"--payload {names}", remedy="leave it away, and discover says more")
    own = with_numbers(fits, held)
    carrying = list(every)
    for k, told, item, mass in zip(links, own.told, held, own.numbers, strict=True):
        ((name, found),) = told.values.items()
        if not found.low > 0.0:
            what = f"a load on the {told.joint} of {name} cannot be told from nothing"
            raise NotEnoughDataError(what, where=f"--payload {name}", remedy=WITHOUT)
        carrying[k] = every[k].with_payload(float(mass), item.along, str(item.claim.place))
    return tuple(carrying[: len(recordings)]), tuple(carrying[len(recordings) :]), own.told
