"""The input that was meant, where the one that was measured has noise.

A measured current is never the same twice: 0.4996 A, 0.5003 A, and -0.0141 A where there was none. What is constant but
for noise is one number (`nominal_inputs`), and numbers that agree are one input. Of what varies and has noise the command is
read off the channel (`commanded_input`): its noise reaches voltages that nobody commanded, and no law of the voltage is to end
there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS, NO_INPUT
from dampyr.records.record import Array, Record

BLOCKS = 10  # equal parts of a record whose means are compared: enough to see a drift or a step
TOLERANCE = 0.02  # of the largest input: the drift of a supply that is set once
NOISE = 0.05  # of the largest input, rms: the noise of a channel that is set to a constant
SMALLEST = 0.5  # V or A: a largest input below it is compared as if it were this, for sensors have an offset
SOURCE, MEASURED = "input_source", "measured"
NORMAL = 1.4826  # a normal distribution's standard deviation over its median absolute value
CLEAN = 1e-3  # of the range of a channel, rms: below it noise moves no end of a law that anybody could tell
FOURTH = math.sqrt(70.0)  # rms of the fourth difference of white noise of rms 1
MIN_SAMPLES = 100  # samples of a channel whose noise is told from its command
WINDOWS = (255, 127, 63, 31, 15, 9)  # samples of a running median, the widest first
STILL_NOISE = 1.05  # times the noise: what a running median may take off; more of it would be the command
SUSTAINED = 2.5  # times the noise: what the median of 9 samples of pure noise exceeds once in ten million samples
SAME_PLATEAU = 5.0  # standard errors of a running median, within which it stays on a plateau
ON_PLATEAUS = 0.8  # of the samples: with fewer the command is not a sequence of plateaus
RARE = 0.005  # of the samples beyond either end of a command without plateaus


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
        Some records have a voltage and others a current, or no input.
    """
    units = {record.input for record in records} - {None}
    if len(units) > 1:
        raise InputError(f"{mixed_inputs(records)}; take records of one kind together")
    inputs = [record.input_channel for record in records]
    blocks = [mean for values in inputs if values is not None for mean in _block_means(np.atleast_1d(values))]
    largest = max([SMALLEST, *map(abs, nominal_values), *map(abs, blocks)])
    steady = [_is_measured(record) and is_steady(record, largest) for record in records]
    stated = {_mean(record) for record in records if record.input_channel is not None and not _is_measured(record)}
    means = sorted({_mean(record) for record, is_constant in zip(records, steady, strict=True) if is_constant})
    nominal = _nominal(means, sorted({0.0, *map(float, nominal_values), *stated}), largest)
    return [
        _constant(record, nominal[_mean(record)]) if is_constant else record
        for record, is_constant in zip(records, steady, strict=True)
    ]


def mixed_inputs(records: Sequence[Record]) -> str:
    """Which records of several kinds of input have which, a record of each: "a has a voltage and b a current as its input"."""
    names = {kind: next((r.name for r in records if r.input == kind), None) for kind in (*INPUTS, NO_INPUT, None)}
    words: dict[str | None, str] = {NO_INPUT: "none", None: "one that is not known"}
    words |= {unit: f"a {word}" for unit, word in INPUTS.items()}
    (first, name), *others = [(kind, name) for kind, name in names.items() if name is not None]
    rest = " and ".join(f"{other} {words[kind]}" for kind, other in others)
    return f"{name} has {words[first]} and {rest} as its input"


@dataclass(frozen=True)
class Commanded:
    """The command behind a channel that varies and has noise: its ``levels`` (k,) in V or A, rising, and the ``noise``, rms.

    The levels are those of its ``plateaus``, or, where it has none, the smoothed channel between its ends.
    """

    levels: Array
    noise: float
    plateaus: bool

    @property
    def low(self) -> float:
        """The lowest level."""
        return float(self.levels[0])

    @property
    def high(self) -> float:
        """The highest level."""
        return float(self.levels[-1])


def commanded_input(values: Array) -> Commanded | None:
    """The command behind a channel (n,); None where the channel has no noise to speak of, or fewer than 100 samples.

    The noise is the scale of the fourth differences, which a command of up to a twentieth of the sampling rate does not enter;
    below a thousandth of the channel's range there is none. The command is the running median over the widest window, of 9 to
    255 samples, that takes off noise alone and leaves nothing sustained beyond the ends that follow from it: where it rests on
    plateaus for 80 % of the samples their medians, those within 2 % of the largest input as one and 0 as 0, else its 0.5 % and
    99.5 % quantiles.
    """
    values = np.asarray(values, dtype=float)
    if values.size < MIN_SAMPLES:
        return None
    noise = NORMAL * float(np.median(np.abs(np.diff(values, 4)))) / FOURTH
    if noise <= CLEAN * float(np.ptp(values)):
        return None
    from scipy.ndimage import median_filter

    short = median_filter(values, WINDOWS[-1], mode="reflect")
    for window in WINDOWS:
        smooth = median_filter(values, window, mode="reflect")
        if NORMAL * float(np.median(np.abs(values - smooth))) > STILL_NOISE * noise:
            continue
        largest = max(SMALLEST, float(np.abs(smooth).max()))
        commanded = _of_plateaus(values, smooth, window, noise, largest)
        if commanded is None:  # its outer quantiles, an end that is 0 but for the tolerance at 0
            ends = np.quantile(smooth, (RARE, 1.0 - RARE))
            low, high = (0.0 if abs(end) <= TOLERANCE * largest else float(end) for end in ends)
            commanded = Commanded(np.unique(np.clip(smooth, low, high)), noise, plateaus=False)
        if commanded.low - SUSTAINED * noise <= short.min() and short.max() <= commanded.high + SUSTAINED * noise:
            return commanded
    return Commanded(np.unique(short), noise, plateaus=False)


def _of_plateaus(values: Array, smooth: Array, window: int, noise: float, largest: float) -> Commanded | None:
    """The levels that a running median rests on; None where it mostly does not rest."""
    reach = SAME_PLATEAU * 1.25 * noise / math.sqrt(window)  # 1.25: the standard error of a median over that of a mean
    levels, resting, first = [], 0, 0
    while first - resting <= (1.0 - ON_PLATEAUS) * smooth.size and first < smooth.size:
        away = np.abs(smooth[first:] - np.median(smooth[first : first + window // 2 + 1])) > reach
        last = first + (int(np.argmax(away)) if away.any() else away.size)
        if last - first > window // 2:
            levels.append(float(np.median(values[first:last])))
            resting += last - first
        first = max(last, first + 1)
    if first < smooth.size:
        return None
    nominal = _nominal(sorted(set(levels)), [0.0], largest)
    return Commanded(np.array(sorted(set(nominal.values()))), noise, plateaus=True)


def in_common(commanded: Sequence[Commanded], stated: Iterable[float] = ()) -> list[Commanded]:
    """The commands, plateaus that agree with each other, 0 or a ``stated`` input at one level: see `nominal_inputs`."""
    levels = sorted({float(level) for command in commanded if command.plateaus for level in command.levels})
    largest = max([SMALLEST, *map(abs, levels)])
    nominal = _nominal(levels, sorted({0.0, *map(float, stated)}), largest)
    return [
        replace(command, levels=np.array(sorted({nominal[float(level)] for level in command.levels})))
        if command.plateaus
        else command
        for command in commanded
    ]


def without_noise_beyond(record: Record, low: float, high: float) -> Record:
    """The record with what noise of its input reaches beyond ``low`` to ``high``, in V or A, at these ends.

    As it is where its input is a number, has no noise, or was commanded beyond them by more than 2 % of the largest
    input and its own noise, which is how well an end is known.
    """
    value = record.input_channel
    if not isinstance(value, np.ndarray) or (low <= value.min() and value.max() <= high):
        return record
    command = commanded_input(value)
    if command is None:
        return record
    slack = TOLERANCE * max(SMALLEST, abs(low), abs(high)) + command.noise
    if command.low < low - slack or command.high > high + slack:
        return record
    name = "voltage" if record.input == "V" else "current"
    ends = f"{low:.4g} to {high:.4g} {record.input}"
    note = f"{name}: what its noise of {command.noise:.2g} {record.input} rms reaches beyond {ends} counts as the end"
    return record.replace(note=note, **{name: np.clip(value, low, high)})


def is_steady(record: Record, largest: float) -> bool:
    """Whether a record's input is constant but for noise; ``largest``, V or A, is what it is compared with.

    A record without an input is not.
    """
    if record.input_channel is None:
        return False
    values = np.atleast_1d(np.asarray(record.input_channel, dtype=float))
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
    if isinstance(record.input_channel, float) and record.input_channel == value:
        return record
    unit = record.input
    note = f"{name} constant but for noise, {_mean(record):.4g} {unit} as measured: counts as {value:.6g} {unit}"
    return record.replace(note=note, provenance=dict(record.provenance) | {SOURCE: "nominal"}, **{name: value})


def _is_measured(record: Record) -> bool:
    """A channel, or a number that is a channel which never changes."""
    return isinstance(record.input_channel, np.ndarray) or record.provenance.get(SOURCE) == MEASURED


def _mean(record: Record) -> float:
    return float(np.mean(np.asarray(record.input_channel, dtype=float)))


def _block_means(values: Array) -> list[float]:
    return [float(np.mean(block)) for block in np.array_split(values, BLOCKS) if len(block)]
