"""One test, one clock: the record of a damper under test.

Everything is SI. Extension is positive; a positive force opposes a positive velocity, so a cycle dissipates.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, findings_of
from dampyr.input_kinds import INPUTS, NO_INPUT
from dampyr.origin import DAY, NOT_STATED, ORIGIN_KINDS, Origin, PublishedData, as_origin
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.records.conditioning.moving_average import MovingAverage
from dampyr.records.conditioning.repair_step import RepairStep
from dampyr.records.record_thresholds import USUAL, RecordThresholds
from dampyr.shown import Shown
from dampyr.source_file import SourceFile
from dampyr.units import in_si

Array = NDArray[np.float64]
Role = Literal["fit", "validation"]

UNEVEN = 0.01  # of the sampling interval: a filter or an average that counts samples needs them even
MIN_SAMPLES = 8  # fewer leave the filter of the velocity nothing to work on
CHANNELS: Mapping[str, str] = MappingProxyType(
    {
        "time": "s",
        "displacement": "m",
        "force": "N",
        "velocity": "m/s",
        "voltage": "V",
        "current": "A",
        "temperature": "degC",
    }
)
"""The channels that a record can hold, each with the unit it is held in."""

GROUPS: Mapping[str, str] = MappingProxyType({"measurement_session": "session", "specimen": "specimen"})
"""The fields by which records belong together, and how tables call them."""

PUBLISHED = ("data_set", "data_set_version", "doi", "licence")
"""What the provenance says of the published data set that a record is from."""

COMMENTS = (*GROUPS, "origin", "input", *PUBLISHED)
"""What files of columns hold as text, where it is stated: groups, the kind of the origin, that there is no input, and the
published data set."""


@dataclass(frozen=True)
class Label:
    """What a table says about a test: never taken for a measurement.

    ``peak_to_peak_m`` in m and ``frequency_hz`` in Hz are as printed; ``table`` and ``row`` say where.
    """

    peak_to_peak_m: float
    frequency_hz: float
    table: str = ""
    row: int | None = None

    def __post_init__(self) -> None:
        for name in ("peak_to_peak_m", "frequency_hz"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"label {name} = {value:g} is not allowed; it must be finite and greater than 0")


@dataclass(frozen=True, eq=False, repr=False)
class Record(Shown):
    """One test on one clock, in SI units, checked when made and never changed afterwards.

    Parameters
    ----------
    time, displacement, force
        ``(n,)`` in s, m and N; time strictly increases, everything is finite, n is at least 8. Quantities and labelled arrays
        are converted from their units, in every channel (:func:`dampyr.units.in_si`).
    velocity
        ``(n,)`` in m/s as recorded or as derived (the history says which), or None.
    voltage, current
        The damper's input at the coil, in V or A: a number, a ``(n,)`` channel or None. At most one of the
        two.
    no_input
        True: the damper has no input, as one of friction, oil or rubber. Without it and without a voltage or a current the
        input is not known, and no fit takes the record.
    temperature
        ``(n,)`` in degC, or None.
    name, role
        What it is called, and whether a fit may use it ("fit") or not ("validation").
    label
        What a table says about it, see :class:`Label`.
    provenance, history
        Where the numbers came from, and what was done to them since, oldest first.
    measurement_session
        Which records share a day and a mounting of the damper: one name for them, such as "2026-03-01", or None.
    specimen
        Which damper was tested, such as its serial number, or None.
    smoothed
        The moving average that some of its channels still hold (:mod:`dampyr.records.conditioning.smoothing`), or None.
    marks
        Faults that the recorder saw in the test, a sentence each, such as a force that stands still while the table moves.
    uncertainty
        The standard uncertainty of channels by their names, with its parts; empty where nobody stated it.
    origin
        Its kind: "measured", "simulated", "virtual", "derived", or "not stated" where nothing says it. It is completed to an
        :class:`~dampyr.origin.Origin` by the record's own file, specimen and session, and by what its provenance says of the
        operator, the date, the data set and dampyr's version.
    source_file
        The name and the SHA-256 of the file that it was read from, or None; reports list them.
    repairs
        What `dampyr.records.repair` changed, oldest first, with the samples as they were: `dampyr.records.undo_repairs` gives
        them back. An ``.h5`` file keeps them, other formats the history alone.
    thresholds
        From when on what it shows is a finding (`dampyr.records.RecordThresholds`). No file of a record keeps them; a fit and
        its card state those that are not as usual.

    Raises
    ------
    InputError
        One sentence naming what is wrong, where, its value and the repair.
    """

    time: Array
    displacement: Array
    force: Array
    velocity: Array | None = None
    voltage: float | Array | None = None
    current: float | Array | None = None
    temperature: Array | None = None
    name: str = "record"
    role: Role = "fit"
    label: Label | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)
    history: tuple[str, ...] = ()
    measurement_session: str | None = None
    specimen: str | None = None
    smoothed: MovingAverage | None = None
    marks: tuple[str, ...] = ()
    uncertainty: Mapping[str, ChannelUncertainty] = field(default_factory=dict)
    source_file: SourceFile | None = None
    origin: Origin = NOT_STATED
    thresholds: RecordThresholds = USUAL
    no_input: bool = False
    repairs: tuple[RepairStep, ...] = ()

    def __post_init__(self) -> None:
        for channel in CHANNELS:
            object.__setattr__(self, channel, _frozen(channel, getattr(self, channel)))
        for name in ("provenance", "uncertainty"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        for name in self.uncertainty:
            if name not in CHANNELS:
                raise InputError(f"uncertainty of {name!r} is of no channel; choose from {', '.join(CHANNELS)}")
        for name in ("history", "marks"):
            if isinstance(getattr(self, name), str):
                raise InputError(f"{name} = {getattr(self, name)!r} is one text; give a tuple of texts")
            object.__setattr__(self, name, tuple(map(str, getattr(self, name))))
        for name in GROUPS:
            object.__setattr__(self, name, as_group(name, getattr(self, name)))
        object.__setattr__(self, "origin", _origin_of(self))
        _check_shapes(self)
        _check_values(self)
        if self.voltage is not None and self.current is not None:
            raise InputError("voltage and current are both given; a record has one input, so leave one of them out")
        if self.no_input and self.input_channel is not None:
            raise InputError(
                f"{INPUTS[self.input or 'V']} is given, and no_input says that the damper has none; leave one of them out"
            )
        if self.role not in ("fit", "validation"):
            raise InputError(f"role = {self.role!r} is not known; choose 'fit' or 'validation'")

    def __reduce__(self) -> tuple[Any, ...]:
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        plain = {"provenance": dict(self.provenance), "uncertainty": dict(self.uncertainty)}
        return _rebuilt, (values | plain,)

    @property
    def n(self) -> int:
        """The number of samples."""
        return len(self.time)

    @property
    def dt(self) -> float:
        """The median sampling interval, s."""
        return float(np.median(np.diff(self.time)))

    @property
    def duration(self) -> float:
        """From the first sample to the last, s."""
        return float(self.time[-1] - self.time[0])

    @property
    def input(self) -> Literal["V", "A", "none"] | None:
        """The unit of the damper's input: "V", "A", "none" where it has none, or None when unknown."""
        if self.voltage is not None:
            return "V"
        if self.current is not None:
            return "A"
        return NO_INPUT if self.no_input else None  # type: ignore[return-value]

    @property
    def input_value(self) -> float | None:
        """The mean of the damper's input in V or A, or None when it has none or it is unknown."""
        value = self.input_channel
        return None if value is None else float(np.mean(value))

    @property
    def input_channel(self) -> float | Array | None:
        """The damper's input in V or A as the record holds it: a number, a channel (n,), or None without one."""
        return self.voltage if self.voltage is not None else self.current

    @property
    def evenly_sampled(self) -> bool:
        """Whether every sampling interval is the median one to 1 %."""
        return not float(np.max(np.abs(np.diff(self.time) - self.dt))) > UNEVEN * self.dt

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All that a person should look at in the record, each once, the worst first.

        Wrong: loops that create energy. Doubts: marks of the recorder, labels that disagree, saturation, false samples, gaps
        and whatever else `quality` notes, a moving average that nobody declared, noise that hides the direction of motion.
        """
        return findings_of(self)

    def replace(self, *, note: str, **changes: Any) -> Record:
        """A new record with these fields changed and ``note``, what was done, added to its history."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        unknown = sorted(set(changes) - set(values))
        if unknown:
            raise InputError(f"a record has no field {unknown[0]!r}; choose from {', '.join(values)}")
        return Record(**(values | {"history": (*self.history, note)} | changes))

    def to_xarray(self) -> Any:
        """The channels as an ``xarray.Dataset`` over time; a constant input is a number.

        Units are in ``attrs`` of each channel, in SI; what is stated of the record, its provenance and its history in those of
        the set, as texts that every format of files takes.

        Examples
        --------
        >>> import numpy as np
        >>> import dampyr as dp
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> record = dp.records.Record(t, 0.01 * np.sin(6 * t), 50.0 * np.cos(6 * t), voltage=1.98)
        >>> data = record.to_xarray()
        >>> data["force"].units, float(data["force"].sel(time=0.0)), float(data["voltage"])
        ('N', 50.0, 1.98)
        """
        import xarray

        held = {name: getattr(self, name) for name in CHANNELS if getattr(self, name) is not None}
        channels = {
            name: ("time" if np.ndim(values) else (), values, {"units": CHANNELS[name], "long_name": name})
            for name, values in held.items()
        }
        about = {"title": self.name, "role": self.role, **stated(self), "history": "\n".join(self.history)}
        about["provenance"] = json.dumps(dict(self.provenance), ensure_ascii=False)
        return xarray.Dataset(channels, {"time": channels.pop("time")}, about)

    def until(self, end: float) -> Record:
        """The record up to the time ``end`` in s, under the same name."""
        window = slice(0, int(np.searchsorted(self.time, end, side="right")))
        if np.size(self.time[window]) < MIN_SAMPLES:
            raise InputError(f"{self.name}: nothing is left before {end:.3g} s; it starts at {self.time[0]:.3g} s")
        return self.sliced(window, f"cut at {end:.6g} s")

    def thinned(self, stride: int) -> Record:
        """Every ``stride``-th sample, nothing averaged."""
        if stride < 1:
            raise InputError(f"stride = {stride} is not allowed; it must be at least 1")
        return self if stride == 1 else self.sliced(slice(None, None, stride), f"every {stride}th sample kept")

    def sliced(self, window: slice, note: str, **changes: Any) -> Record:
        """The samples of ``window``, with ``note`` in the history and other fields changed as by `replace`."""
        channels = {name: getattr(self, name) for name in CHANNELS}
        parts = {name: values[window] for name, values in channels.items() if isinstance(values, np.ndarray)}
        return self.replace(note=note, **parts, **changes)


def _origin_of(record: Record) -> Origin:
    """The kind of the origin, completed by what the record says of itself."""
    provenance = record.provenance

    def entries(value: Any) -> tuple[Any, ...]:
        return (value,) if value else ()

    data_set = provenance.get("data_set", "")
    return Origin(
        as_origin(record.origin).kind,
        sources=entries(record.source_file),
        operators=entries(provenance.get("operator")),
        specimens=entries(record.specimen),
        sessions=entries(record.measurement_session),
        dates=entries((provenance.get("date") or provenance.get("started", ""))[:DAY]),
        data_sets=entries(
            data_set
            and PublishedData(data_set, *(provenance.get(name, "") for name in ("doi", "licence", "data_set_version")))
        ),
        versions=entries(provenance.get("dampyr")),
    )


def _rebuilt(values: dict[str, Any]) -> Record:
    return Record(**values)


def _frozen(channel: str, value: Any) -> Any:
    """A read-only float64 copy of a channel; a plain float for an input that is constant."""
    if value is None:
        return None
    try:
        array = np.array(in_si(value, CHANNELS[channel], channel), dtype=np.float64)
    except InputError:
        raise
    except (TypeError, ValueError):
        raise InputError(f"{channel} is not numbers; give an array of them in {CHANNELS[channel]}") from None
    if array.ndim == 0 and channel in ("voltage", "current"):
        return float(array)
    array.setflags(write=False)
    return array


def _check_shapes(record: Record) -> None:
    n = np.size(record.time)
    for channel, unit in CHANNELS.items():
        value = getattr(record, channel)
        if value is None and channel in ("time", "displacement", "force"):
            raise InputError(f"{channel} is missing; give one value in {unit} per sample")
        if value is None or isinstance(value, float):
            continue
        if value.ndim != 1:
            raise InputError(f"{channel} has the shape {value.shape}; give one column of {n} values")
        if len(value) != n:
            raise InputError(f"{channel} has {len(value)} values and time has {n}; give one value per sample")
    if n < MIN_SAMPLES:
        raise InputError(f"the record has {n} samples; give at least {MIN_SAMPLES}")


def _check_values(record: Record) -> None:
    for channel, unit in CHANNELS.items():
        value = getattr(record, channel)
        if value is None:
            continue
        bad = np.flatnonzero(~np.isfinite(np.atleast_1d(value)))
        if len(bad) and isinstance(value, float):
            raise InputError(f"{channel} = {value} {unit} is not finite; give the value that was applied")
        if len(bad):
            i = int(bad[0])
            raise InputError(
                f"{channel}[{i}] = {value[i]} {unit} is not finite ({len(bad)} such of {len(value)}); "
                "repair or cut out those samples"
            )
    back = np.flatnonzero(np.diff(record.time) <= 0)
    if len(back):
        i = int(back[0]) + 1
        raise InputError(
            f"time[{i}] = {record.time[i]:.9g} s does not come after {record.time[i - 1]:.9g} s; "
            "time must strictly increase, so sort or cut the samples"
        )


def commonest_name(records: Iterable[Record]) -> tuple[str, int]:
    """The name that most of the records have, and how many have it; ``("", 0)`` without records."""
    names = Counter(record.name for record in records).most_common(1)
    return names[0] if names else ("", 0)


def stated(record: Record) -> dict[str, str]:
    """The `COMMENTS` that a record has."""
    held = {name: getattr(record, name) for name in GROUPS} | {"origin": record.origin.kind}
    held["input"] = NO_INPUT if record.no_input else None
    held |= {name: record.provenance.get(name) for name in PUBLISHED}
    return {name: text for name, text in held.items() if text not in (None, "", NOT_STATED.kind)}


def as_stated(texts: Mapping[str, str]) -> dict[str, str]:
    """Those of a file's texts that are `COMMENTS`: the inverse of `stated`.

    Another word for the origin or the input is that of somebody else's file, and means something else there.
    """
    allowed = {"origin": ORIGIN_KINDS, "input": (NO_INPUT,)}
    held = {name: texts[name].strip() for name in COMMENTS if texts.get(name, "").strip()}
    return {name: text for name, text in held.items() if name not in allowed or text in allowed[name]}


def as_group(name: str, text: Any) -> str | None:
    """The name of a session or of a specimen without blanks around it, or None; else an :class:`InputError`.

    Records are grouped by these names, so that what is not a name, or only looks like another one, is refused.
    """
    if text is None:
        return None
    if not isinstance(text, str):
        raise InputError(f"{name} = {text!r} is not a text; give a name in quotes, or leave it out")
    trimmed = text.strip()
    if not trimmed or not trimmed.isprintable():
        raise InputError(f"{name} = {text!r} is not a name; give one line of text that is not empty, or leave it out")
    return trimmed


def as_role(text: str) -> Role:
    """``text`` as a role, or an :class:`InputError`."""
    if text not in ("fit", "validation"):
        raise InputError(f"role = {text!r} is not known; choose 'fit' or 'validation'")
    return cast(Role, text)
