"""Certificates of calibration: read at the boundary, kept with a record, judged at the day of the test."""

from datetime import date

import pytest

from dampyr.config import fill, parse_toml
from dampyr.errors import InputError
from dampyr.records.checks.certificates import (
    Certificates,
    certificates_in_words,
    certificates_of,
    expired_certificates,
)

TEXT = """
[load_cell]
date = 2026-03-01
expires = 2027-03-01
instrument = "4711"
reference = "the national laboratory, K-123"
uncertainty = "0.1 %"
coverage_factor = 2
[encoder]
date = 2026-02-01
uncertainty = "1 um"
"""


def test_quantities_are_read_with_their_units_and_a_stated_uncertainty_is_divided_by_its_factor() -> None:
    certificates = fill(Certificates, parse_toml(TEXT), "certificates")
    assert certificates.standard("load_cell") == pytest.approx(5e-4)
    assert certificates.standard("encoder") == pytest.approx(1e-6)
    assert certificates.standard("board") is None


def test_they_come_back_from_a_record_as_they_were() -> None:
    certificates = fill(Certificates, parse_toml(TEXT), "certificates")
    assert certificates_of(certificates.provenance()) == certificates
    (_, cell), (_, encoder) = certificates_in_words(certificates.provenance())
    assert cell == (
        "no. 4711, calibrated on 2026-03-01, until 2027-03-01, against the national laboratory, K-123, 0.0005 of the value "
        "(one sigma)"
    )
    assert encoder == "calibrated on 2026-02-01, no expiry is stated, 1e-06 m (one sigma)"


def test_a_rig_without_certificates_adds_nothing_to_a_record() -> None:
    assert Certificates().provenance() == {}
    assert expired_certificates({"started": "2026-03-01T10:00:00+00:00"}) == []


@pytest.mark.parametrize(("day", "expired"), [("2027-03-01", False), ("2027-03-02", True), ("2026-03-05", False)])
def test_it_is_judged_at_the_day_of_the_record(day: str, expired: bool) -> None:
    certificates = fill(Certificates, parse_toml(TEXT), "certificates")
    sentences = expired_certificates({"started": f"{day}T10:00:00+00:00"} | certificates.provenance())
    assert len(sentences) == expired
    assert all("load cell (no. 4711) had expired on 2027-03-01" in sentence for sentence in sentences)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"date": "soon"}, "date = 'soon' of a certificate is no date"),
        ({"date": date(2026, 3, 1), "expires": date(2026, 2, 1)}, "is before its date"),
        ({"expires": date(2026, 3, 1)}, "certificates.load_cell.date is missing"),
        ({"date": date(2026, 3, 1), "uncertainty": "1 N"}, "certificates.load_cell.uncertainty"),
    ],
)
def test_what_is_wrong_in_it_is_refused_with_a_sentence(table: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        fill(Certificates, {"load_cell": table}, "certificates")
