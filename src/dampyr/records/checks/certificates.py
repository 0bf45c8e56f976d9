"""Certificates of calibration: by what, when and how well an instrument was calibrated, and until when that holds.

They stand in ``rig.toml``, a table for each channel, and travel with every record; whether one had expired is judged at the
time of the record, not of reading it.
"""

from __future__ import annotations

import datetime
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any, ClassVar

from dampyr.config import fill
from dampyr.errors import InputError
from dampyr.units import Quantity

KEY = "certificates"  # of a record's provenance


@dataclass(frozen=True)
class Certificate:
    """What a certificate of calibration says of an instrument."""

    date: Annotated[datetime.date, "day of the calibration"]
    expires: Annotated[datetime.date | None, "last day on which it holds"] = None
    instrument: Annotated[str, "serial number of the instrument"] = ""
    reference: Annotated[str, "who or what it was calibrated against, and the certificate's number"] = ""
    coverage_factor: Annotated[
        float, Quantity("", low=0.1, high=10.0), "k of the uncertainty that is stated: 2 for an expanded one"
    ] = 1.0

    unit: ClassVar[str] = "of the value"
    """In which the uncertainty is stated."""

    def __post_init__(self) -> None:
        for name in ("date", "expires"):
            object.__setattr__(self, name, _day(name, getattr(self, name)))
        if self.expires is not None and self.expires < self.date:
            raise InputError(
                f"expires = {self.expires} of a certificate is before its date = {self.date}; correct one of them"
            )

    @property
    def standard(self) -> float | None:
        """The standard uncertainty, the stated one over its coverage factor; None where none is stated."""
        stated: float | None = getattr(self, "uncertainty", None)
        return None if stated is None else stated / self.coverage_factor

    def in_words(self) -> str:
        """In one line: instrument, days, reference and standard uncertainty."""
        standard = self.standard
        known = [
            f"no. {self.instrument}" if self.instrument else "",
            f"calibrated on {self.date}",
            f"until {self.expires}" if self.expires else "no expiry is stated",
            f"against {self.reference}" if self.reference else "",
            "" if standard is None else f"{standard:.2g} {self.unit} (one sigma)",
        ]
        return ", ".join(filter(None, known))

    def expired(self, day: datetime.date) -> bool:
        """Whether it held no more on a day."""
        return self.expires is not None and day > self.expires


@dataclass(frozen=True)
class RelativeCertificate(Certificate):
    """A certificate whose uncertainty is relative."""

    uncertainty: Annotated[float | None, Quantity("", low=0.0), "relative, such as 0.1 %"] = None


@dataclass(frozen=True)
class LengthCertificate(Certificate):
    """A certificate whose uncertainty is a length."""

    uncertainty: Annotated[float | None, Quantity("m", low=0.0), "of the position"] = None

    unit: ClassVar[str] = "m"


@dataclass(frozen=True)
class TemperatureCertificate(Certificate):
    """A certificate whose uncertainty is a difference of temperatures."""

    uncertainty: Annotated[float | None, Quantity("K", low=0.0), "of the temperature"] = None

    unit: ClassVar[str] = "K"


@dataclass(frozen=True)
class Certificates:
    """Certificates of calibration of the channels, none where none is known."""

    load_cell: Annotated[RelativeCertificate | None, "with its amplifier: of the scale"] = None
    encoder: Annotated[LengthCertificate | None, "of the position"] = None
    thermocouple: Annotated[TemperatureCertificate | None, "with its amplifier"] = None
    coil_voltage: Annotated[RelativeCertificate | None, "with its divider and the board"] = None
    coil_current: Annotated[RelativeCertificate | None, "with its shunt and the board"] = None
    board: Annotated[RelativeCertificate | None, "of its volts; it stands in the parts above and replaces none"] = None

    def stated(self) -> Iterator[tuple[str, Certificate]]:
        """The channels that have one, such as "coil voltage", and their certificates."""
        for field in fields(self):
            certificate = getattr(self, field.name)
            if certificate is not None:
                yield field.name.replace("_", " "), certificate

    def standard(self, channel: str) -> float | None:
        """The standard uncertainty of a channel; None where none is stated."""
        certificate = getattr(self, channel)
        return None if certificate is None else certificate.standard

    def provenance(self) -> dict[str, str]:
        """The entry of a record's provenance; none without a certificate."""
        known = {name: value for name, value in asdict(self).items() if value is not None}
        return {KEY: json.dumps(known, default=str)} if known else {}


def certificates_of(provenance: Mapping[str, str]) -> Certificates:
    """The certificates that a record's provenance holds."""
    return fill(Certificates, json.loads(provenance[KEY]), KEY) if provenance.get(KEY) else Certificates()


def certificates_in_words(provenance: Mapping[str, str]) -> list[tuple[str, str]]:
    """A line for each certificate of a record: "load cell's certificate" and what it says."""
    stated = certificates_of(provenance).stated()
    return [(f"{name}'s certificate", certificate.in_words()) for name, certificate in stated]


def expired_certificates(provenance: Mapping[str, str]) -> list[str]:
    """A sentence for each certificate that had expired when the record was taken."""
    if not provenance.get(KEY):
        return []
    day = _day_of(provenance)
    return [
        f"the certificate of the {name}{f' (no. {certificate.instrument})' if certificate.instrument else ''} had expired on "
        f"{certificate.expires}, before this test of {day}: have it calibrated, and test again or "
        "look at the values with that in mind"
        for name, certificate in certificates_of(provenance).stated()
        if day is not None and certificate.expired(day)
    ]


def _day_of(provenance: Mapping[str, str]) -> datetime.date | None:
    """The day of a record, as the rig's host counted it."""
    try:
        return datetime.datetime.fromisoformat(provenance["started"]).date()
    except (KeyError, ValueError):  # a record that was edited by hand: no day, no judgement
        return None


def _day(name: str, value: Any) -> datetime.date | None:
    if value is None and name == "expires":
        return None
    if isinstance(value, datetime.datetime):
        return value.date()
    if isinstance(value, datetime.date):
        return value
    try:
        return datetime.date.fromisoformat(str(value))
    except ValueError:
        raise InputError(f"{name} = {value!r} of a certificate is no date; give a day such as 2026-03-01") from None
