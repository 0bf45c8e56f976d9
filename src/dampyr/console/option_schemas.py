"""Requests and forms of the console that come from a class of options (`dampyr.options`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, BeforeValidator, Field, create_model

from dampyr.options import Option, Options, options_of
from dampyr.units import in_si

MAX_TEXT, MAX_ITEMS = 200, 60  # characters of a text, and entries of a list


class OptionsRequest(BaseModel):
    """A part of a request: values of options, in SI units; those of ``LEFT_OUT`` are given in another way, or not at all."""

    OPTIONS: ClassVar[type[Options]]
    LEFT_OUT: ClassVar[tuple[str, ...]] = ()

    def options(self, **others: Any) -> Any:
        """The object of options that the values mean, with ``others`` for what is left out."""
        names = [option.name for option in options_of(self.OPTIONS) if option.name not in self.LEFT_OUT]
        return self.OPTIONS(**{name: getattr(self, name) for name in names}, **others)


def request_of(
    cls: type[Options],
    leave_out: tuple[str, ...] = (),
    usual: Mapping[str, Any] | None = None,
    highest: Mapping[str, float] | None = None,
) -> Any:
    """The class of requests that hold a value for each option of ``cls``: a base for those that hold records, too.

    ``usual`` values stand in the place of those of ``cls``, and ``highest`` ones limit what a server computes.
    """
    defaults, limits = usual or {}, highest or {}
    fields = {}
    for option in options_of(cls):
        if option.name not in leave_out:
            default = defaults.get(option.name, option.default)
            default = list(default) if isinstance(default, tuple) else default
            words = f"{option.words}: {option.values(si=True)}."
            kind = _type(option, limits.get(option.name, math.inf))
            fields[option.name] = (kind, Field(default=default, description=words))
    request = create_model(f"{cls.__name__}Request", __base__=OptionsRequest, **fields)  # type: ignore[call-overload]
    request.OPTIONS, request.LEFT_OUT = cls, leave_out
    return request


def _number(option: Option, value: Any) -> Any:
    """A text, such as ``"10 ms"`` or ``"2"``, in SI; all else as it is."""
    return in_si(value, option.unit, option.name) if isinstance(value, str) else value


def _type(option: Option, limit: float = math.inf) -> Any:
    single: Any = option.kind
    if option.kind is str:
        single = Annotated[str, Field(max_length=MAX_TEXT)]
    elif option.quantity is not None:
        low, high = option.quantity.low, min(option.quantity.high, limit)
        bounds: dict[str, Any] = {"le": high} if math.isfinite(high) else {}
        bounds |= {"gt" if option.quantity.open_low else "ge": low} if math.isfinite(low) else {}
        bounds |= {"allow_inf_nan": False} if option.kind is float else {}
        with_unit = [BeforeValidator(partial(_number, option))] if option.kind is float else []
        single = Annotated[option.kind, Field(**bounds), *with_unit]
        if option.choices and option.kind is float:
            single = single | Annotated[str, Field(max_length=MAX_TEXT)]
    if option.several:
        single = Annotated[list[single], Field(max_length=MAX_ITEMS)]
    elif option.pairs:
        pairs = Annotated[dict[str, single], Field(max_length=MAX_ITEMS)]
        single = single | pairs if option.for_all else pairs
    return single | None if option.optional else single


def form_of(
    cls: type[Options], leave_out: tuple[str, ...] = (), usual: Mapping[str, Any] | None = None
) -> list[dict[str, Any]]:
    """What the page makes a form of: a control for each option, with its usual value; numbers in SI, and how they are shown.

    ``usual`` is as that of `request_of`.
    """
    defaults = usual or {}
    return [
        {
            "name": option.name,
            "label": option.name.replace("_", " ").capitalize(),
            "words": option.words,
            "kind": option.kind.__name__,
            "several": option.several,
            "pairs": option.pairs,
            "for_all": option.for_all,
            "optional": option.optional,
            "choices": None if option.choices is None else list(option.choices.items()),
            "default": defaults.get(option.name, option.default),
            "unit": option.shown_in,
            "factor": option.factor,
            "group": option.group,
            "placeholder": f"{option.metavar}; …" if option.several or option.pairs else "",
        }
        for option in options_of(cls)
        if option.name not in leave_out
    ]
