"""Which parameters a search of models holds, and which have one value at all inputs.

A fit has a value of each parameter at each input, unless its part says that it is constant. What mounts a damper seldom depends
on the input, and what shapes its force need not. So a search tries add-ons with one value of each parameter first, and asks
which of the parameters that shape a finalist's force predict as well with one
(`dampyr.identification.model_choice.screening`). Parameters that the force of a model is proportional to are left alone: a
damper's force follows its input.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from dampyr.identification.fits.fit_options import FitOptions
from dampyr.models import Damper, compose
from dampyr.models.codegen.composition import Composition
from dampyr.models.part import part
from dampyr.records import Record

#: compositions that are tried like a model of the catalogue, and what one of the two parts leaves to the other
PAIRS = {"dahl + hyperbolic_tangent": {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}}


def hold_pairs(options: FitOptions, model: str | Composition | Damper) -> FitOptions:
    """The options, with what a pair of parts within ``model`` holds unless one of them names it."""
    laws = options.laws if isinstance(options.laws, Mapping) else {}
    named = {*options.fixed, *laws, *options.tied, *options.tied.values()}
    held = {name: value for name, value in list_held(model).items() if name not in named}
    return replace(options, fixed=held | dict(options.fixed)) if held else options


def list_held(model: str | Composition | Damper) -> dict[str, float]:
    """The parameters that a pair within ``model`` holds, in SI units."""
    composition = compose(model) if isinstance(model, str) else model
    parts = set((composition.composition if isinstance(composition, Damper) else composition).names)
    pairs = [held for pair, held in PAIRS.items() if set(compose(pair).names) <= parts]
    return {name: value for held in pairs for name, value in held.items()}


def may_follow_input(options: FitOptions, records: Sequence[Record]) -> bool:
    """Whether a search chooses which parameters follow the input: the records have several, and no law was asked for."""
    varies = any(isinstance(record.input_channel, np.ndarray) for record in records)
    return options.laws is None and (varies or len({record.input_value for record in records}) > 1)


def list_shapes(model: str) -> list[str]:
    """The parameters of a model that may follow the input and need not, the last first: those of add-ons, and the others that
    shape the force. Left out are those that are held, or of which only the sum with another is seen."""
    composition = compose(model)
    aside = {*composition.constant, *list_held(model), *composition.twins, *composition.twins.values()}
    if composition.lag is not None:  # the delay of the input does not depend on the input
        aside.add(composition.parameters[composition.lag])
    added = {name for name in composition.parameters if part(name.partition(".")[0]).add_on}
    return [
        name
        for name in reversed(composition.parameters)
        if name not in aside and (name in added or not composition.quantities[name].linear)
    ]


def with_constant(options: FitOptions, constant: Sequence[str]) -> FitOptions:
    """The options with one value at all inputs for the named parameters."""
    return replace(options, laws=dict.fromkeys(constant, "constant")) if constant else options
