"""A damper: a composition of parts whose parameters follow the input, with the range it was calibrated on."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.data_frames import column_name, data_frame
from dampyr.errors import DampyrWarning, ExtrapolationWarning, InputError, RangeError
from dampyr.findings import Finding
from dampyr.input_kinds import INPUTS, KINDS, NO_INPUT, unit_of
from dampyr.models import card
from dampyr.models.codegen.composition import Composition, compose
from dampyr.models.laws import Constant, Interpolation, Law, WithTemperature, onto_limits
from dampyr.models.part import part_name
from dampyr.models.prediction_error import (
    PredictionError,
    at_level,
    check_level,
    draws_of,
    force_draws,
    moved,
    square_root,
    with_session_prior,
)
from dampyr.origin import NOT_STATED, Origin, as_origin
from dampyr.phrases import listing
from dampyr.shown import Shown
from dampyr.units import in_si

if TYPE_CHECKING:
    from dampyr.models.inverse import Inverse

Array = NDArray[np.float64]
RANGES = {"displacement": "m", "velocity": "m/s", "frequency": "Hz"}
# Times the calibrated displacement or velocity: a path of a test is not there, and one in mm is at 1000 times.
FAR = 20.0
UNLIKELY = {"displacement": 1.0, "velocity": 10.0}  # m, m/s, where no calibrated range says what is usual
SAME_TEMPERATURE = 0.5  # °C: less than one tells two temperatures of a damper apart by
ROWS = 11  # inputs of a table over the calibrated range: each tenth of it


@dataclass(frozen=True, eq=False, repr=False)
class Damper(Shown):
    """A damper, made of one or more parts.

    Parameters
    ----------
    parts
        such as ``"dahl + spring"`` or ``("dahl", "spring")``: names of ``dampyr.models.parts``. Also part objects, as `at`
        returns them: ``[Dahl(kx=800.0, kw=50.0, rho=900.0), Spring(k0=200.0)]``; their numbers are constant laws.
    laws
        one law per parameter that no part object has, by its name (``"kx"``, or ``"dahl.kx"`` where several parts have one of
        that name), in SI units over the input; a number means a constant, values at inputs such as
        ``{0.0: 900.0, 2.0: 3000.0}`` an `Interpolation`. A damper of numbers alone holds at every input and needs none.
    input
        ``"V"``: the voltage at the coil, ``"A"``: its current, or ``"none"``: the damper has no input, as one of friction, oil
        or rubber; all of its laws are then numbers, and nothing that is made of it speaks of an input.
    ranges
        what the calibration covered: ``displacement`` (m, peak), ``velocity`` (m/s, peak), ``frequency`` (Hz) -> (low, high).
    covariance
        of the laws' coefficients in their order, shape (m, m), or None where it is unknown.
    within_records
        the fitted numbers, such as ``"dahl.kx @ 1.98 V"``, whose variance holds within the fitted records only: each was
        determined by one or two records, so the variance between records is not in the covariance.
    bandwidth
        of the derivative that gives the velocity where none is passed, in Hz; None: plain central differences.
    provenance
        where the numbers come from, for people.
    prediction_error
        how far a measured force may be from the predicted one (`dampyr.models.prediction_error`): the levels of sessions and
        records and the residual; None where that was not estimated.
    findings
        what a person should look at, the worst first: the verdict on the fit, faults of its records. What is made of the damper
        repeats those that are wrong or in doubt (`dampyr.findings.handed_on`).
    origin
        of what it was identified from (`dampyr.origin`): "measured" only where every record was; "not stated" where nothing
        says it.

    Raises
    ------
    InputError
        a law is missing, or leaves the allowed values inside its range. A law that misses a limit of its parameter by rounding
        alone, 1e-7 of its largest term, is put on that limit.

    Examples
    --------
    >>> import dampyr as dp
    >>> damper = dp.models.Damper("dahl + offset", {"kx": 900.0, "kw": 250.0, "rho": 9000.0, "f0": 120.0})
    >>> damper.needs_input, damper.at(0.0)[1]
    (False, Offset(f0=120.0))
    """

    parts: str | Sequence[Any]
    laws: Mapping[str, Law | float | Mapping[float, float]] = field(default_factory=dict)
    input: str = "V"
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    covariance: Array | None = None
    bandwidth: float | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)
    within_records: tuple[str, ...] = ()
    prediction_error: PredictionError | None = None
    findings: Sequence[Finding] = ()
    origin: Origin = NOT_STATED

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", as_origin(self.origin))
        names, constants = _separate_constants(self.parts)
        composition = compose(names)
        named = {_complete_name(name, composition): law for name, law in self.laws.items()}
        if len(named) < len(self.laws):
            raise InputError(f"a parameter is given twice among {', '.join(self.laws)}; give each once")
        twice = sorted(set(constants) & set(named))
        if twice:
            raise InputError(f"{twice[0]} is given twice, by its part and in laws; leave it out of laws")
        object.__setattr__(self, "laws", {**constants, **named})
        object.__setattr__(self, "parts", composition.names)
        object.__setattr__(self, "composition", composition)
        self._check_names()
        units = {name: quantity.unit or "dimensionless" for name, quantity in composition.quantities.items()}
        in_si_units = {name: in_si(self.laws[name], units[name], name) for name in composition.parameters}
        object.__setattr__(self, "laws", in_si_units)
        laws = {name: self._law(name, law) for name, law in in_si_units.items()}
        object.__setattr__(self, "laws", laws)
        for name, quantity in composition.quantities.items():
            low, high = laws[name].extremes()
            if low < quantity.low or high > quantity.high:
                laws[name] = onto_limits(laws[name], quantity)
                low, high = laws[name].extremes()
            law = laws[name]
            everywhere = isinstance(law, Constant) and law.is_everywhere
            where = (
                name if everywhere else f"{name} between {law.low:g} and {law.high:g} {unit_of(self.input)}".rstrip()
            )
            quantity.check(where, low)
            quantity.check(where, high)
        self._check_constants()
        k = composition.lag
        if k is not None and not isinstance(laws[composition.parameters[k]], Constant):
            raise InputError(
                f"{composition.parameters[k]} must be a constant: it is the time constant of the input itself"
            )
        self._check_covariance()
        self._check_prediction_error()

    composition: Composition = field(init=False, repr=False)

    def _check_names(self) -> None:
        if self.input not in KINDS:
            raise InputError(f"the input of a damper is 'V', 'A' or 'none', not {self.input!r}")
        wanted, given = set(self.composition.parameters), set(self.laws)
        if given - wanted:
            raise InputError(
                f"{', '.join(sorted(given - wanted))} is not a parameter of {self.composition}; "
                f"it has {', '.join(self.composition.parameters)}"
            )
        if wanted - given:
            raise InputError(f"{self.composition} lacks a law for {', '.join(sorted(wanted - given))}")

    def _check_constants(self) -> None:
        """A damper without an input has one number for each parameter, and no lag between a command and its force."""
        if self.has_input:
            return
        over = [name for name, law in self.all_laws.items() if not _is_number(law)]
        if over:  # first of all what is no number: its range is that of the numbers beside it, too
            name = next((name for name in over if not isinstance(self.all_laws[name], Constant)), over[0])
            raise InputError(
                f"{name} follows an input and the damper's input is 'none'; give it as a number, or say which input: 'V' or "
                "'A'"
            )
        if self.composition.lag is not None:
            raise InputError("the part lag is the lag of an input, and the damper's input is 'none'; leave lag out")

    def _check_covariance(self) -> None:
        if self.covariance is None:
            return
        matrix = np.array(self.covariance, dtype=float)
        if matrix.shape != (self.coefficients.size,) * 2:
            raise InputError(
                f"the covariance has shape {matrix.shape}; the laws have {self.coefficients.size} coefficients"
            )
        matrix.setflags(write=False)
        object.__setattr__(self, "covariance", matrix)

    def _check_prediction_error(self) -> None:
        error = self.prediction_error
        if error is None:
            return
        if self.covariance is None:
            raise InputError("a prediction error needs the covariance of the coefficients; give both, or neither")
        if error.directions.shape[1] != self.coefficients.size:
            raise InputError(
                f"the prediction error's directions have {error.directions.shape[1]} columns; the laws have "
                f"{self.coefficients.size} coefficients"
            )

    def _law(self, name: str, law: Any) -> Law:
        if isinstance(law, Mapping):
            unit = self.composition.quantities[name].unit or "dimensionless"
            return Interpolation(tuple(law), tuple(in_si(value, unit, name) for value in law.values()))
        if isinstance(law, int | float):
            ranged = [k for k in self.laws.values() if not isinstance(k, int | float)]
            low = max((min(k) if isinstance(k, Mapping) else k.low for k in ranged if k), default=-np.inf)
            high = min((max(k) if isinstance(k, Mapping) else k.high for k in ranged if k), default=np.inf)
            return Constant(float(law), low, high)
        if not hasattr(law, "extremes"):
            raise InputError(
                f"{name} = {law!r} is not a law; give a number, values at inputs such as {{0.0: 900.0, 2.0: 3000.0}}, or a law "
                "such as dampyr.models.Polynomial(coefficients, low, high)"
            )
        return law

    def to_dataframe(self, inputs: ArrayLike | None = None) -> Any:
        """The parameters as a ``pandas.DataFrame`` in SI units: one row an input, by default tenths of the calibrated range."""
        if inputs is None:
            low, high = self.range
            inputs = np.linspace(low, high, ROWS) if low < high else low
        at = np.atleast_1d(np.asarray(inputs, dtype=float))
        if not self.has_input:
            at = np.zeros(1)
        quantities = self.composition.quantities
        columns = {
            column_name(name, quantities[name].unit): values
            for name, values in zip(self.laws, self.at_mean_temperature.values(at).T, strict=True)
        }
        if not self.has_input:
            return data_frame(columns)
        return data_frame(columns, at.tolist(), column_name(INPUTS[self.input], self.input))

    @property
    def all_laws(self) -> dict[str, Law]:
        """The laws by flat parameter name."""
        return dict(self.laws)  # type: ignore[arg-type]

    @property
    def has_input(self) -> bool:
        """False where the damper is one without an input, such as one of friction, oil or rubber."""
        return self.input != NO_INPUT

    @cached_property
    def needs_input(self) -> bool:
        """False where every law is a number that holds at every input, and where there is none."""
        return self.has_input and not all(
            isinstance(law, Constant) and law.is_everywhere for law in self.all_laws.values()
        )

    @cached_property
    def range(self) -> tuple[float, float]:
        """The inputs that every law was calibrated on; (0, 0) where no input is needed."""
        laws = self.all_laws.values()
        return (max(law.low for law in laws), min(law.high for law in laws)) if self.needs_input else (0.0, 0.0)

    @property
    def input_lag(self) -> float:
        """The time constant [s] by which the input follows its command; 0 without the part ``lag``."""
        k = self.composition.lag  # a constant, so any input gives it
        return 0.0 if k is None else float(list(self.all_laws.values())[k](self.range[0]))

    @property
    def range_words(self) -> str:
        """The calibrated range as a sentence on the damper says it."""
        low, high = self.range
        if not self.has_input:
            return "has no input"
        return f"is calibrated from {low:g} to {high:g} {self.input}" if self.needs_input else "holds at every input"

    @cached_property
    def coefficients(self) -> Array:
        """All coefficients of the laws, in the order of the parameters."""
        return np.concatenate([law.coefficients for law in self.all_laws.values()])

    def with_coefficients(self, coefficients: ArrayLike) -> Self:
        """The same damper with other coefficients in its laws."""
        numbers, start, laws = np.asarray(coefficients, dtype=float), 0, {}
        for name, law in self.all_laws.items():
            stop = start + len(law.coefficients)
            laws[name] = law.with_coefficients(numbers[start:stop])
            start = stop
        return replace(self, laws=laws)

    @cached_property
    def temperatures(self) -> tuple[float, float] | None:
        """The temperatures in degC that its laws were calibrated on, or None where no law depends on the temperature."""
        spans = [law.temperatures for law in self.all_laws.values() if isinstance(law, WithTemperature)]
        return (max(low for low, _ in spans), min(high for _, high in spans)) if spans else None

    def at_temperature(self, temperature: float, allow_extrapolation: bool = False) -> Damper:
        """The damper at one temperature in degC: its laws depend on the input alone, as buildings and exports need them.

        Itself where no law depends on the temperature. Raises :class:`~dampyr.errors.RangeError` outside the calibrated
        temperatures unless allowed by name (then it warns).
        """
        if self.temperatures is None:
            return self
        (low, high), degrees = self.temperatures, float(temperature)
        if not np.isfinite(degrees):
            raise InputError(f"a temperature of {degrees:g} °C is not allowed; it must be finite")
        if not low - SAME_TEMPERATURE <= degrees <= high + SAME_TEMPERATURE:
            text = f"{degrees:g} °C is outside the calibrated temperatures {low:.4g} to {high:.4g} °C"
            if not allow_extrapolation:
                raise RangeError(f"{text}; stay inside them, or pass allow_extrapolation=True")
            warnings.warn(f"{text}: extrapolated", ExtrapolationWarning, stacklevel=3)
        laws: dict[str, Law] = {}
        mixed = []
        for name, law in self.all_laws.items():
            mixing = np.eye(len(law.coefficients))
            if isinstance(law, WithTemperature):
                laws[name], s = law.at_temperature(degrees), law.share(degrees)
                half = len(mixing) // 2
                mixing = np.hstack([(1.0 - s) * np.eye(half), s * np.eye(half)])
            else:
                laws[name] = law
            mixed.append(mixing)
        covariance, error = None, self.prediction_error
        if self.covariance is not None:
            covariance = mapped_covariance(block_diagonal(mixed), self.covariance)
        if error is not None:
            error = error.mapped(block_diagonal(mixed))
        provenance = dict(self.provenance) | {"temperature": f"{degrees:g} °C"}
        return replace(self, laws=laws, covariance=covariance, provenance=provenance, prediction_error=error)

    @property
    def at_mean_temperature(self) -> Damper:
        """Itself, or in the middle of its temperatures, for figures and tables."""
        return self if self.temperatures is None else self.at_temperature(float(np.mean(self.temperatures)))

    def without(self, *names: str) -> Damper:
        """The damper less some of its parts, such as ``"delay"`` where the delay belongs to the rig and not to the damper."""
        unknown = [name for name in names if name not in self.composition.names]
        if unknown:
            raise InputError(f"{unknown[0]!r} is not a part of {self.composition}")
        laws = {key: law for key, law in self.all_laws.items() if key.partition(".")[0] not in names}
        sizes = [len(law.coefficients) for law in self.all_laws.values()]
        retained = np.repeat([key in laws for key in self.all_laws], sizes)
        return replace(
            self,
            parts=tuple(name for name in self.composition.names if name not in names),
            laws=laws,
            covariance=None if self.covariance is None else self.covariance[np.ix_(retained, retained)],
            within_records=tuple(label for label in self.within_records if label.partition(".")[0] not in names),
            prediction_error=self._with_columns(np.flatnonzero(retained)),
        )

    def _with_columns(self, columns: NDArray[np.int64]) -> PredictionError | None:
        """The prediction error of some of the coefficients; -1 stands for one that the sessions' levels do not move."""
        if self.prediction_error is None:
            return None
        size = self.coefficients.size
        return self.prediction_error.mapped(np.eye(size + 1)[columns, :size])

    def at_level(self, level: float) -> Damper:
        """The damper with ``level`` times the dynamic force, such as 0.9 where a session came out 10 % weaker."""
        return at_level(self, level)

    def with_session_prior(self, session_prior: float) -> Damper:
        """The damper with another stated level between measurement sessions, 0.08 being 8 %: its bands and draws are then those
        of a fit with this ``session_prior``. Raises InputError where the level was estimated and not stated."""
        if self.prediction_error is None:
            raise InputError("this damper has no prediction error, so no prior of sessions is in it; identify it again")
        return replace(self, prediction_error=with_session_prior(self.prediction_error, session_prior))

    def on_brace(self, stiffness: float) -> Damper:
        r"""The damper in series with a brace of ``stiffness`` k [N/m]: the damper feels the motion less F/k.

        The brace is the part ``compliance``, whose s grows by 1/k; in a damper that has one already the two add up. All of
        the damper is in series with it, its spring too; strokes are then those of damper and brace together. The step of a
        response counts to first order only (docs/explanations/building.md). Raises InputError for a part that needs the
        acceleration (inertia), which would act in parallel with the brace.
        """
        if isinstance(stiffness, bool) or not np.isfinite(stiffness) or stiffness <= 0:
            raise InputError(f"the stiffness of a brace {stiffness!r} N/m is not allowed; it must be greater than 0")
        inertial = [p.name for p in self.composition.parts if p.needs_acceleration]
        if inertial:
            raise InputError(
                f"{inertial[0]} needs the acceleration and would act in parallel with the brace, not in series; "
                f"leave it out first, with .without({inertial[0]!r})"
            )
        laws = self.all_laws
        if "compliance.s" in laws:
            return replace(self, laws=laws | {"compliance.s": laws["compliance.s"].shifted(1.0 / stiffness)})
        covariance = None if self.covariance is None else np.pad(self.covariance, (0, 1))  # the brace is known exactly
        parts = (*self.composition.names, "compliance")
        return replace(
            self,
            parts=parts,
            laws=laws | {"compliance.s": 1.0 / stiffness},
            covariance=covariance,
            prediction_error=self._with_columns(np.append(np.arange(self.coefficients.size), -1)),
        )

    def check_input(self, u: ArrayLike, allow_extrapolation: bool = False) -> Array:
        """``u`` as an array; :class:`~dampyr.errors.RangeError` outside the calibrated range unless allowed by name."""
        if not self.has_input:
            return np.zeros(np.shape(u))
        values = np.asarray(in_si(u, self.input, INPUTS[self.input]), dtype=float)
        if not np.all(np.isfinite(values)):
            raise InputError(f"the {INPUTS[self.input]} holds a value that is not finite")
        low, high = self.range
        slack = 1e-9 * max(abs(low), abs(high), 1.0)  # a file has an input to 15 digits, arithmetic to a few less
        worst = values.max() if values.max() > high + slack else values.min()
        if low - slack <= worst <= high + slack or not self.needs_input:
            return values
        text = (
            f"{INPUTS[self.input]} {worst:g} {self.input} is outside the calibrated range "
            f"{low:g} to {high:g} {self.input}"
        )
        if not allow_extrapolation:
            raise RangeError(f"{text}; stay inside it, or pass allow_extrapolation=True")
        warnings.warn(f"{text}: extrapolated", ExtrapolationWarning, stacklevel=4)
        return values

    def values(self, u: ArrayLike, static: bool = True, allow_extrapolation: bool = False) -> Array:
        """The parameters at the input ``u``: (P,) for a number, (n, P) for an array, in SI units.

        ``static=False`` sets static forces (the offset) to zero. Raises :class:`~dampyr.errors.RangeError` outside the
        calibrated range unless ``allow_extrapolation``, and InputError where extrapolation leaves the allowed values.
        """
        inputs = self.check_input(u, allow_extrapolation)
        table = np.stack([np.asarray(law(inputs), dtype=float) for law in self.all_laws.values()], axis=-1)
        for k, (name, quantity) in enumerate(self.composition.quantities.items()):
            values = table[..., k]
            if values.min() < quantity.low or values.max() > quantity.high:
                values[...] = quantity.without_rounding(values, float(np.abs(values).max()))
            for extreme in (values.min(), values.max()):
                where = f" at {_format_span(inputs)} {self.input}" if self.has_input else ""
                quantity.check(f"{name}{where}", float(extreme))
        if not static:
            table[..., list(self.composition.static)] = 0.0
        return table

    def delay(self, u: float, allow_extrapolation: bool = False) -> float:
        """The delay in s at the input ``u``; 0 without a delay part."""
        k = self.composition.delay
        return 0.0 if k is None else float(self.values(u, allow_extrapolation=allow_extrapolation)[k])

    def at(self, u: float = 0.0, allow_extrapolation: bool = False) -> Any:
        """The model at one input: the part's dataclass, or a tuple of them where there are several parts.

        A damper without an input is the same whatever ``u`` is.

        Examples
        --------
        >>> import dampyr as dp
        >>> dp.studies.raminelli_2020.damper().at(0.0)
        Dahl(kx=802.0, kw=50.237, rho=42745.0)
        """
        number = float(in_si(u, self.input, INPUTS[self.input])) if self.has_input else 0.0
        values = self.values(number, allow_extrapolation=allow_extrapolation)
        models, start = [], 0
        for p in self.composition.parts:
            stop = start + len(p.parameters)
            models.append(p.cls(*map(float, values[start:stop])))
            start = stop
        return models[0] if len(models) == 1 else tuple(models)

    def pick_input(self, voltage: ArrayLike | None, current: ArrayLike | None) -> ArrayLike:
        """The input that this damper takes, of the two; InputError where it is the other one, or none.

        One that needs no input takes either, and 0 where none is given; one without an input takes none.
        """
        if not self.has_input:
            refuse_input(voltage, current)
            return 0.0
        wanted, other = (voltage, current) if self.input == "V" else (current, voltage)
        if not self.needs_input:
            return next((value for value in (wanted, other) if value is not None), 0.0)
        word = INPUTS[self.input]
        if other is not None:
            raise InputError(f"this damper was calibrated over {word} in {self.input}; pass {word}=, not the other")
        if wanted is None:
            raise InputError(f"this damper needs its {word}; pass {word}= in {self.input}")
        return wanted

    def force(
        self,
        t: ArrayLike,
        x: ArrayLike,
        voltage: ArrayLike | None = None,
        current: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        state0: ArrayLike | None = None,
        allow_extrapolation: bool = False,
        temperature: float | None = None,
    ) -> Array:
        """The force in N, shape (n,), along a path; quantities and labelled arrays are converted from their units
        (`dampyr.units.in_si`).

        Parameters
        ----------
        t
            (n,) s, rising.
        x
            (n,) m; between samples the path is straight.
        voltage, current
            the input of the damper, a number or (n,) in V or A: the one that it was calibrated over.
        velocity
            (n,) m/s; by default the derivative of x with the damper's ``bandwidth``.
        state0
            the hysteretic states at the start; by default 0, no memory.
        allow_extrapolation
            also at an input outside the calibrated range, with a warning.
        temperature
            degC, of a damper whose laws depend on it (see `at_temperature`).

        Returns
        -------
        array
            (n,) N. A motion beyond the calibrated displacement or velocity gives one warning that names the limit; samples too
            far apart for a part's friction (`dampyr.models.sampling_error`) give one that says by how much.

        Raises
        ------
        RangeError
            an input outside the calibrated range, or a motion beyond 20 times the calibrated one (1 m and 10 m/s where a card
            over an input states none): is the path in mm?
        InputError
            an input that is missing, or not the damper's; channels of different lengths or that are not finite.

        Examples
        --------
        >>> import numpy as np
        >>> import dampyr as dp
        >>> damper = dp.studies.raminelli_2020.damper()
        >>> t = np.linspace(0.0, 4.0, 801)
        >>> x = 0.008 * np.sin(2 * np.pi * t)
        >>> force = damper.force(t, x, voltage=1.98)
        >>> force.shape, round(float(force.max()))
        ((801,), 510)
        """
        time, displacement, speed = self.check_path(t, x, velocity)
        if not allow_extrapolation:
            self._check_units(displacement, speed)
        return self.force_of_motion(
            time, displacement, voltage, current, speed, state0, allow_extrapolation, temperature
        )

    def force_of_motion(
        self,
        t: ArrayLike,
        x: ArrayLike,
        voltage: ArrayLike | None = None,
        current: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        state0: ArrayLike | None = None,
        allow_extrapolation: bool = False,
        temperature: float | None = None,
    ) -> Array:
        """`force` along a motion that was computed, such as that of a building: however far it is beyond the calibrated
        displacement or velocity, it gives a warning and asks nothing about units.
        """
        from dampyr.models.input_lag import lagged
        from dampyr.models.path_integration import along, delayed
        from dampyr.models.sampling_error import sampling_words

        if temperature is not None and self.temperatures is not None:
            fixed = self.at_temperature(temperature, allow_extrapolation)
            return fixed.force_of_motion(t, x, voltage, current, velocity, state0, allow_extrapolation)
        t, x, v = self.check_path(t, x, velocity)
        u = self._input_along(self.pick_input(voltage, current), t)
        self.warn_outside(x, v)
        if self.input_lag:
            u = np.asarray(lagged(t, u, self.input_lag))
        values = self.values(u, allow_extrapolation=allow_extrapolation)
        start = self.check_states(state0)
        undelayed = along(self.composition, t, x, v, values, start)
        self._refuse_unbounded(t, undelayed)
        if text := sampling_words(self.composition, t, x, v, values, start):
            warnings.warn(text, DampyrWarning, stacklevel=3)
        k = self.composition.delay
        return undelayed if k is None else delayed(t, undelayed, np.asarray(values[..., k]))

    def inverse(
        self,
        displacement: float = 0.0,
        velocity: float = 0.0,
        low: float | None = None,
        high: float | None = None,
        state0: ArrayLike | None = None,
        allow_extrapolation: bool = False,
    ) -> Inverse:
        """The damper run backwards, which finds the input of a wanted force step by step (`dampyr.models.inverse.Inverse`).

        Parameters
        ----------
        displacement, velocity, state0
            m, m/s and the hysteretic states where it starts.
        low, high
            the bounds of the input in V or A; by default the calibrated range, which they may leave with
            ``allow_extrapolation`` only.

        Returns
        -------
        Inverse
            ``step(displacement, velocity, wanted_force, dt)`` goes on by a step, ``along(t, x, wanted_force)`` along a path.

        Raises
        ------
        InputError
            a damper without an input, or whose force is delayed or needs the acceleration; bounds in the wrong order.
        RangeError
            bounds outside the calibrated range.

        Examples
        --------
        >>> import dampyr as dp
        >>> inverse = dp.studies.raminelli_2020.damper().inverse()
        >>> found = inverse.step(displacement=0.001, velocity=0.05, wanted_force=300.0, dt=0.02)
        >>> round(found.input, 3), found.reason
        (0.992, 'met')
        """
        from dampyr.models.inverse import Inverse

        return Inverse(self, displacement, velocity, low, high, state0, allow_extrapolation)

    def band(
        self,
        t: ArrayLike,
        x: ArrayLike,
        voltage: ArrayLike | None = None,
        current: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        level: float = 0.9,
        session: str | None = None,
        draws: int = 200,
        seed: int = 0,
        allow_extrapolation: bool = False,
        temperature: float | None = None,
    ) -> tuple[Array, Array]:
        """The limits (n,) in N between which a measured force along a path is expected with the probability ``level``.

        `dampyr.identification.prediction_band` compares a record with it.

        Parameters
        ----------
        t, x, voltage, current, velocity, temperature
            the path, as in `force`.
        level
            share of the measured force that lies between the limits, between 0 and 1.
        session
            a fitted measurement session by its name; by default the band holds for a record of another session.
        draws, seed
            how many draws the limits are quantiles of, and their seed.
        allow_extrapolation
            also at an input outside the calibrated range, with a warning.

        Returns
        -------
        two arrays
            (n,) N, with the offset that the damper has.

        Raises
        ------
        InputError
            the damper has no `prediction_error`, or was not fitted on that session.
        """
        check_level(level)
        if temperature is not None and self.temperatures is not None:
            fixed = self.at_temperature(temperature, allow_extrapolation)
            return fixed.band(t, x, voltage, current, velocity, level, session, draws, seed, allow_extrapolation)
        time, displacement, speed = self.check_path(t, x, velocity)
        path = {"t": time, "x": displacement, "voltage": voltage, "current": current, "velocity": speed}
        forces, noise = force_draws(self, path, draws, seed, session, allow_extrapolation)
        low, high = np.quantile(forces + noise, (0.5 * (1.0 - level), 0.5 * (1.0 + level)), axis=0)
        return low, high

    def _input_along(self, u: ArrayLike, t: Array) -> Array:
        if not self.has_input:
            return np.zeros(())
        values = np.asarray(in_si(u, self.input, INPUTS[self.input]), dtype=float)
        if values.ndim and values.shape != t.shape:
            raise InputError(
                f"{INPUTS[self.input]} has shape {values.shape}, the path {t.shape}; give one number or as many"
            )
        return values

    def _refuse_unbounded(self, t: Array, force: Array) -> None:
        """InputError where a part whose force may be infinite has made it so."""
        beyond = np.flatnonzero(~np.isfinite(force))
        for p in self.composition.parts if beyond.size else ():
            if p.unbounded:
                raise InputError(
                    f"the force is infinite at {t[beyond[0]]:g} s: {p.name} has no limit, as {p.unbounded}; "
                    "keep to the strokes that it was identified on"
                )

    def _velocity(self, t: Array, x: Array, velocity: ArrayLike | None) -> Array:
        from dampyr.models.numerics.differentiation import differentiate

        if velocity is None:
            return differentiate(t, x, self.bandwidth)
        v = np.ascontiguousarray(in_si(velocity, "m/s", "velocity"), dtype=float)
        if v.shape != x.shape or not np.all(np.isfinite(v)):
            raise InputError(f"velocity has shape {v.shape}, the path {x.shape}; give as many finite values")
        return v

    def check_path(self, t: ArrayLike, x: ArrayLike, velocity: ArrayLike | None = None) -> tuple[Array, Array, Array]:
        """A path in s, m and m/s, each (n,), with the derivative of x where no ``velocity`` is given; InputError where it is
        none."""
        time, displacement = _check_path(t, x)
        return time, displacement, self._velocity(time, displacement, velocity)

    def check_states(self, state0: ArrayLike | None) -> Array | None:
        """The hysteretic states at a start as an array, None for none; InputError where one is missing or out of bounds."""
        if state0 is None:
            return None
        s = np.atleast_1d(np.asarray(state0, dtype=float))
        bounds = self.composition.states
        if s.shape != (len(bounds),):
            raise InputError(f"state0 has {s.size} values; {self.composition} has {len(bounds)} states")
        for (name, (low, high)), value in zip(bounds.items(), s, strict=True):
            if not low <= value <= high:
                raise InputError(f"the initial state {name} = {value:g} must lie between {low:g} and {high:g}")
        return s

    def _reached(self, x: Array, v: Array) -> list[tuple[str, float, float | None]]:
        """Name, what a motion reaches of it, and the calibrated limit or None, of displacement and velocity."""
        peaks = {"displacement": 0.5 * float(np.ptp(x)), "velocity": float(np.abs(v).max())}
        limits = {name: self.ranges[name][1] if name in self.ranges else None for name in peaks}
        return [(name, peak, limits[name]) for name, peak in peaks.items()]

    def _check_units(self, x: Array, v: Array) -> None:
        """Ask whether the unit of a path is right that is far beyond what was calibrated."""
        for name, peak, limit in self._reached(x, v):
            if limit is None and not self.needs_input:
                continue  # a textbook set, which may have no unit at all
            if peak > (UNLIKELY[name] if limit is None else FAR * limit):
                unit = RANGES[name]
                calibrated = (
                    f"and the card states no calibrated {name}, of which more than {UNLIKELY[name]:g} {unit} is unlikely"
                    if limit is None
                    else f"{peak / limit:.0f} times what the damper was calibrated on, {limit:.4g} {unit}"
                )
                raise RangeError(
                    f"{name} reaches {peak:.4g} {unit}, {calibrated}; is the path in mm? Give it in m, or as a quantity with "
                    "its unit; for what is meant so, pass allow_extrapolation=True"
                )

    def warn_outside(self, x: Array, v: Array) -> None:
        """Warn of a motion (n,) m, (n,) m/s beyond the calibrated displacement or velocity."""
        for name, peak, limit in self._reached(x, v):
            if limit is not None and peak > 1.01 * limit:
                unit = RANGES[name]
                warnings.warn(
                    f"{name} reaches {peak:.4g} {unit}; the damper was calibrated up to {limit:.4g} {unit}",
                    DampyrWarning,
                    stacklevel=4,
                )

    def draws(self, n: int, seed: int, levels: bool = True) -> list[Damper]:
        """``n`` dampers from the distribution of the fit: normal in the coefficients, and inside the allowed values
        (`dampyr.models.prediction_error`).

        With a `prediction_error` each draw is the damper as a test of another session would find it: with the levels of the
        fitted sessions and that of the session to come, and Student's t in the place of the normal distribution.
        ``levels=False`` leaves the levels out. Warns where the covariance holds within the fitted records only: where
        only one or two records determine a coefficient, the difference to another record is not in it. Raises
        InputError without a covariance, or where a coefficient was unidentifiable in the fit.
        """
        covariance = self.finite_covariance()
        if self.within_records:
            warnings.warn(
                f"the draws of {listing(self.within_records, 3)} hold within the fitted records only: between-record variance "
                "is not estimated from fewer than three records; record three or more at each input",
                DampyrWarning,
                stacklevel=2,
            )
        rng = np.random.default_rng(seed)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)  # of doubtful values the damper itself has warned
            if levels and self.prediction_error is not None:
                return [draw.damper.at_level(draw.level) for draw in draws_of(self, self.prediction_error, n, rng)]
            root = square_root(covariance)
            return [moved(self, root @ rng.standard_normal(len(root))) for _ in range(n)]

    def finite_covariance(self) -> Array:
        """The covariance of the coefficients; :class:`~dampyr.errors.InputError` unless dampers can be drawn from it."""
        if self.covariance is None:
            raise InputError("this damper has no covariance to draw from; identify it from records first")
        if not np.all(np.isfinite(self.covariance)):
            raise InputError(
                "the variance of a coefficient is infinite: the records do not determine it; see its fit's notes"
            )
        return self.covariance

    def save(self, path: str | Path) -> Path:
        """Write the card, a TOML file (docs/reference/card.md), whole or not at all.

        Examples
        --------
        >>> import dampyr as dp
        >>> card = dp.studies.raminelli_2020.damper().save("damper.toml")
        >>> dp.models.Damper.load(card).range
        (0.0, 3.212)
        """
        return card.write(self, Path(path))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a card; :class:`~dampyr.errors.FileError` says what is wrong with it.

        Examples
        --------
        >>> import dampyr as dp
        >>> card = dp.studies.raminelli_2020.damper().save("damper.toml")
        >>> damper = dp.models.Damper.load(card)
        >>> damper.input, damper.range
        ('V', (0.0, 3.212))
        """
        return card.read(Path(path), cls)


def refuse_input(voltage: Any, current: Any) -> None:
    """:class:`~dampyr.errors.InputError` where a voltage or a current is given to a damper that has no input."""
    for word, value in (("voltage", voltage), ("current", current)):
        if value is not None:
            raise InputError(f"this damper has no input, and {word}= is given; leave it out")


def _is_number(law: Law) -> bool:
    """Whether a law has one value, at every temperature or at two of them."""
    sides = (law.cold, law.warm) if isinstance(law, WithTemperature) else (law,)
    return all(isinstance(side, Constant) and side.is_everywhere for side in sides)


def _complete_name(name: str, composition: Composition) -> str:
    """The name of a parameter with its part; a name that is not one of the composition's stays as it is."""
    full = [parameter for parameter in composition.parameters if parameter.partition(".")[2] == name]
    if len(full) > 1:
        raise InputError(f"{name} is a parameter of several parts; write {' or '.join(full)}")
    return full[0] if full else name


def _separate_constants(parts: Any) -> tuple[str | list[str], dict[str, float]]:
    """The names of parts that are given as text, as objects or as both, and the parameters of the objects."""
    if isinstance(parts, str):
        return parts, {}
    names, constants = [], {}
    for part in parts if isinstance(parts, Iterable) else [parts]:
        name = part if isinstance(part, str) else part_name(part)
        names.append(name)
        if not isinstance(part, str):
            constants.update(
                {f"{name}.{parameter.name}": float(getattr(part, parameter.name)) for parameter in fields(part)}
            )
    return names, constants


def block_diagonal(blocks: list[Array]) -> Array:
    """The matrix with these blocks on its diagonal."""
    from scipy.linalg import block_diag

    return np.asarray(block_diag(*blocks))


def mapped_covariance(T: Array, covariance: Array) -> Array:
    """The covariance of coefficients that ``T`` makes of others; infinite where one of those was."""
    finite = np.where(np.isfinite(covariance), covariance, 0.0)
    out = T @ finite @ T.T
    for k in np.flatnonzero(~np.isfinite(np.diag(covariance))):
        rows = np.flatnonzero(T[:, k])
        out[rows, rows] = np.inf
    return np.asarray(0.5 * (out + out.T))


def _check_path(t: ArrayLike, x: ArrayLike) -> tuple[Array, Array]:
    time = np.ascontiguousarray(in_si(t, "s", "t"), dtype=float)
    displacement = np.ascontiguousarray(in_si(x, "m", "x"), dtype=float)
    if time.ndim != 1 or time.shape != displacement.shape or time.size < 2:
        raise InputError(f"t {time.shape} and x {displacement.shape} must be two vectors of the same length, 2 or more")
    if not (np.all(np.isfinite(time)) and np.all(np.isfinite(displacement))):
        raise InputError("t and x must be finite; a value is NaN or infinite")
    if np.any(np.diff(time) <= 0):
        k = int(np.argmax(np.diff(time) <= 0))
        raise InputError(f"t must rise; t[{k + 1}] = {time[k + 1]:g} s follows t[{k}] = {time[k]:g} s")
    return time, displacement


def _format_span(u: Array) -> str:
    return f"{u.min():g}" if u.min() == u.max() else f"{u.min():g} to {u.max():g}"
