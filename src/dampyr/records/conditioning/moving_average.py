r"""A moving average over N samples, of which b lie before each sample and a after it (:math:`N = b + 1 + a`):

.. math:: y_n = \frac1N \sum_{k=-b}^{a} r_{n+k}.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]
Alignment = Literal["centred", "trailing"]
AVERAGED = ("displacement", "velocity", "force")  # what a laboratory publishes smoothed; the input is a setting
UNITS = {"s": "seconds", "samples": "samples", "periods": "periods"}
KEYS = (*UNITS.values(), "trailing", "channels", "undo")
EXAMPLE = '"0.3 s", "15 samples" or "0.1 periods"'


@dataclass(frozen=True)
class Declaration:
    """A declared moving average: the window of a moving average in s, in samples or in periods of the motion.

    ``trailing``: the window ends with the sample (else the sample is in its middle; of an even number of samples one more lies
    before it). ``channels``: those that were smoothed. ``undo``: whether it is undone where it can be.

    Raises :class:`~dampyr.errors.InputError` for a window that is none.
    """

    seconds: float | None = None
    samples: int | None = None
    periods: float | None = None
    trailing: bool = False
    channels: tuple[str, ...] = AVERAGED
    undo: bool = True

    def __post_init__(self) -> None:
        windows = {name: getattr(self, name) for name in UNITS.values() if getattr(self, name) is not None}
        if len(windows) != 1:
            raise InputError(f"smoothed needs one window and has {len(windows)}; give one, such as {EXAMPLE}")
        [(name, value)] = windows.items()
        is_window = not isinstance(value, bool) and np.isfinite(value) and value > 0.0
        if not is_window or (name == "samples" and (value < 2 or value % 1)):
            unit = next(word for word, field in UNITS.items() if field == name)
            raise InputError(
                f"smoothed = {value:g} {unit} is not a valid window; give a number above 0, of samples a whole one from 2 on"
            )
        wrong = [c for c in self.channels if c not in AVERAGED]
        if wrong or not self.channels:
            what = f"{wrong[0]!r} is not a channel that can be smoothed" if wrong else "no channel is smoothed"
            raise InputError(f"smoothed: {what}; choose from {', '.join(AVERAGED)}")

    @staticmethod
    def of(declared: Any) -> Declaration:
        """From a number of s, from a text such as ``"0.1 periods, trailing, force"``, or from a mapping of the fields."""
        if isinstance(declared, Declaration):
            return declared
        if isinstance(declared, Mapping):
            return _from_mapping(declared)
        if isinstance(declared, str):
            return _from_text(declared)
        if isinstance(declared, int | float) and not isinstance(declared, bool):
            return Declaration(seconds=float(declared))
        raise InputError(f"smoothed = {declared!r} is not a valid window; give s as a number, or {EXAMPLE}")

    @property
    def window(self) -> str:
        """The window with its unit, such as "0.1 periods"."""
        word, value = next((w, getattr(self, f)) for w, f in UNITS.items() if getattr(self, f) is not None)
        return f"{value:g} {word}"

    def __str__(self) -> str:
        """All that is declared, as :meth:`of` takes it."""
        channels = () if self.channels == AVERAGED else self.channels
        words = (*(["trailing"] if self.trailing else []), *([] if self.undo else ["not undone"]), *channels)
        return ", ".join((self.window, *words))


def _from_text(text: str) -> Declaration:
    first, *rest = (word.strip() for word in text.split(","))
    match = re.fullmatch(r"([0-9.eE+-]+)\s*(s|samples|periods)?", first)
    try:
        value = float(match[1]) if match else math.nan
    except ValueError:
        value = math.nan
    if match is None or math.isnan(value):
        raise InputError(f"smoothed = {text!r} is not a valid window; write it as in {EXAMPLE}")
    fields: dict[str, Any] = {UNITS[match[2] or "s"]: value}
    channels = tuple(word for word in rest if word in AVERAGED)
    flags = [word for word in rest if word not in AVERAGED]
    unknown = [word for word in flags if word not in ("trailing", "centred", "not undone")]
    if unknown:
        raise InputError(
            f"smoothed = {text!r}: {unknown[0]!r} is not among trailing, centred, not undone, {', '.join(AVERAGED)}; correct it"
        )
    if channels:
        fields["channels"] = channels
    return _with_whole_samples(fields | {"trailing": "trailing" in flags, "undo": "not undone" not in flags})


def _from_mapping(declared: Mapping[str, Any]) -> Declaration:
    unknown = [key for key in declared if key not in KEYS]
    if unknown:
        raise InputError(f"smoothed: {unknown[0]!r} is not among {', '.join(KEYS)}; correct it")
    fields = dict(declared)
    for key in ("trailing", "undo"):
        if not isinstance(fields.get(key, True), bool):
            raise InputError(f"smoothed: {key} = {fields[key]!r} is neither true nor false; write one of them")
    for key in UNITS.values():
        if key in fields and (isinstance(fields[key], bool) or not isinstance(fields[key], int | float)):
            raise InputError(f"smoothed: {key} = {fields[key]!r} is not a number; give one above 0")
    if "channels" in fields:
        channels = fields["channels"]
        if isinstance(channels, str) or not all(isinstance(channel, str) for channel in channels):
            raise InputError(f'smoothed: channels = {channels!r} is not a list of channels; write it as in ["force"]')
        fields["channels"] = tuple(channels)
    return _with_whole_samples(fields)


def _with_whole_samples(fields: dict[str, Any]) -> Declaration:
    samples = fields.get("samples")
    if isinstance(samples, float) and samples.is_integer():
        fields["samples"] = int(samples)
    return Declaration(**fields)


@dataclass(frozen=True)
class MovingAverage:
    """A moving average that channels of a record went through: ``window`` in s, and which ``channels`` still hold it."""

    window: float
    alignment: Alignment = "centred"
    channels: tuple[str, ...] = AVERAGED

    def __post_init__(self) -> None:
        if not (np.isfinite(self.window) and self.window > 0.0):
            raise InputError(f"the window of a moving average is {self.window:g} s; it must be greater than 0")
        if self.alignment not in ("centred", "trailing"):
            raise InputError(f"alignment = {self.alignment!r} is not allowed; choose 'centred' or 'trailing'")

    def reach(self, dt: float) -> tuple[int, int]:
        """How many samples ``dt`` s apart lie in the window before and after the sample itself."""
        return reach_of(max(round(self.window / dt), 1), self.alignment == "trailing")

    def without(self, channels: tuple[str, ...]) -> MovingAverage | None:
        """The same for what is left of its channels, or None."""
        left = tuple(channel for channel in self.channels if channel not in channels)
        return replace(self, channels=left) if left else None


def reach_of(samples: int, trailing: bool) -> tuple[int, int]:
    """The samples of a window before and after its own sample; centred, an even number has one more before."""
    return (samples - 1, 0) if trailing else (samples // 2, (samples - 1) // 2)


def averaged(values: Array, before: int, after: int) -> Array:
    """The moving average of ``values`` (n,) or (n, k) along the first axis; at the ends over what is there of the window."""
    n = values.shape[0]
    total = np.concatenate((np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)))
    first = np.maximum(np.arange(n) - before, 0)
    last = np.minimum(np.arange(n) + after + 1, n)
    count = (last - first).astype(float)
    return np.asarray((total[last] - total[first]) / (count[:, None] if values.ndim > 1 else count))


def whole_windows(n: int, before: int, after: int) -> slice:
    """The samples of ``n`` whose window lies inside the record."""
    return slice(min(before, n), max(n - after, min(before, n)))
