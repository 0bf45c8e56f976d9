"""The input that was meant, where the one that was measured has noise.

A measured current is never the same twice: 0.4996 A, 0.5003 A, and -0.0141 A where there was none. What is constant but
for noise is one number, and numbers that agree are one input.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from dampyr.errors import InputError
from dampyr.records.record import Array, Record

BLOCKS = 10  # equal parts of a record whose means are compared: enough to see a drift or a step
TOLERANCE = 0.02  # of the largest input: the drift of a supply that is set once
NOISE = 0.05  # of the largest input, rms: the noise of a channel that is set to a constant
SMALLEST = 0.5  # V or A: a largest input below it is compared as if it were this, for sensors have an offset
SOURCE, MEASURED = "input_source", "measured"


def nominal_inputs(records: Sequence[Record], nominal_values: Iterable[float] = ()) -> list[Record]:
    """The records with measured inputs that are constant but for noise as constants, those that agree as one.

    With U the largest input of all records (of their block means; at least 0.5 V or A), a record's input is constant where the
    means of ten equal blocks stay within 2 % of U of its mean and the rms deviation is at most 5 % of U. Such means are one
    input when, in order, they follow one another within 2 % of U and span at most 4 % of U: their mean, rounded to the decimal
    place below a tenth of that tolerance. Where they lie within 2 % of U of an input that is known, they are that one: 0, the
    inputs in ``nominal_values``, and those that other records have as a stated number.

    A record whose input varies, and one whose input was stated, come back as they are. The history of a changed one says so.

    Raises
    ------
    InputError
        Some records have a voltage and others a current.
    """
    units = {record.input for record in records} - {None}
    if len(units) > 1:
        named = {unit: next(r.name for r in records if r.input == unit) for unit in ("V", "A")}
        raise InputError(
            f"{named['V']} has a voltage and {named['A']} a current as its input; take records of one kind together"
        )
    largest = max([SMALLEST, *map(abs, nominal_values), *(_largest(record) for record in records)])
    steady = [_is_measured(record) and is_steady(record, largest) for record in records]
    stated = {_mean(r) for r in records if r.input and not _is_measured(r)}
    means = sorted({_mean(r) for r, yes in zip(records, steady, strict=True) if yes})
    nominal = _nominal(means, sorted({0.0, *map(float, nominal_values), *stated}), largest)
    return [_constant(r, nominal[_mean(r)]) if yes else r for r, yes in zip(records, steady, strict=True)]


def is_steady(record: Record, largest: float) -> bool:
    """Whether a record's input is constant but for noise; ``largest``, V or A, is what it is compared with.

    A record without an input is not.
    """
    values = _channel(record)
    if values is None:
        return False
    mean = float(np.mean(values))
    away = max(abs(block - mean) for block in _block_means(values))
    return away <= TOLERANCE * largest and float(np.std(values)) <= NOISE * largest


def agrees(stated: float, measured: Array) -> bool:
    """Whether a channel is the stated number but for noise and a sensor's error: 5 % of it, or 0.05 V or A if that is more."""
    tolerance = max(0.05 * abs(stated), 0.05)
    return all(abs(block - stated) <= tolerance for block in _block_means(np.atleast_1d(measured)))


def _nominal(means: list[float], nominal_values: list[float], largest: float) -> dict[float, float]:
    """The input that each mean stands for; the means in rising order."""
    tolerance = TOLERANCE * largest
    assigned: dict[float, float] = {}
    free = []
    for mean in means:
        nearest = min(nominal_values, key=lambda value: abs(value - mean))
        if abs(nearest - mean) <= tolerance:
            assigned[mean] = nearest
        else:
            free.append(mean)
    places = -math.floor(math.log10(tolerance / 10.0))
    for group in _groups(free, tolerance):
        value = round(float(np.mean(group)), places)
        assigned |= dict.fromkeys(group, value) if group[-1] - group[0] <= 2.0 * tolerance else {u: u for u in group}
    return assigned


def _groups(values: list[float], tolerance: float) -> list[list[float]]:
    """Values in rising order, cut where one is more than ``tolerance`` from the next."""
    groups: list[list[float]] = []
    for value in values:
        if groups and value - groups[-1][-1] <= tolerance:
            groups[-1].append(value)
        else:
            groups.append([value])
    return groups


def _constant(record: Record, value: float) -> Record:
    name = "voltage" if record.input == "V" else "current"
    if isinstance(_value(record), float) and _value(record) == value:
        return record
    unit = record.input
    note = f"{name} constant but for noise, {_mean(record):.4g} {unit} as measured: counts as {value:.6g} {unit}"
    return record.replace(note=note, provenance=dict(record.provenance) | {SOURCE: "nominal"}, **{name: value})


def _channel(record: Record) -> Array | None:
    value = _value(record)
    return None if value is None else np.atleast_1d(np.asarray(value, dtype=float))


def _is_measured(record: Record) -> bool:
    """A channel, or a number that is a channel which never changes."""
    return isinstance(_value(record), np.ndarray) or record.provenance.get(SOURCE) == MEASURED


def _value(record: Record) -> float | Array | None:
    return record.voltage if record.voltage is not None else record.current


def _mean(record: Record) -> float:
    return float(np.mean(np.asarray(_value(record), dtype=float)))


def _block_means(values: Array) -> list[float]:
    return [float(np.mean(block)) for block in np.array_split(values, BLOCKS) if len(block)]


def _largest(record: Record) -> float:
    values = _channel(record)
    return 0.0 if values is None else max(map(abs, _block_means(values)))
