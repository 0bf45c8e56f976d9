"""Labels held against what is measured, and loops that create energy."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, measure
from dampyr.records.checks.label_checks import disagreements
from dampyr.records.record import Label


def test_an_unlabelled_good_record_agrees(make_sine):
    assert disagreements(make_sine()) == []


def test_an_inverted_force_is_flagged(make_sine):
    said = disagreements(make_sine(viscous=-3000.0, name="upside down"))
    assert len(said) == 1
    assert said[0].startswith("upside down: its loops create energy")
    assert said[0].endswith("force sign inverted?")


@pytest.mark.parametrize(("off", "words"), [((1.1, 1.0), "Hz"), ((1.0, 0.9), "mm peak to peak"), ((1.02, 0.98), None)])
def test_a_label_that_disagrees_is_reported(make_sine, off, words):
    said = disagreements(make_sine(label=Label(0.02 * off[1], 0.9 * off[0])))
    assert len(said) == (0 if words is None else 1)
    assert words is None or words in said[0]


def test_a_record_without_cycles_cannot_confirm_its_label():
    t = 0.01 * np.arange(100)
    still = Record(t, np.zeros(100), np.ones(100), label=Label(0.02, 1.0))
    assert "cannot be checked" in disagreements(still)[0]
    with pytest.raises(InputError, match="no whole cycle"):
        measure(still)


def test_only_row_10_of_table_4_3_disagrees(published):
    said = {record.name: disagreements(record) for record in published}
    assert {name for name, sentences in said.items() if sentences} == {"ensaio10.2.2"}
    frequency, peak_to_peak = said["ensaio10.2.2"]
    assert "labelled 0.8474 Hz, measures 0.675" in frequency
    assert "labelled 22.41 mm peak to peak, measures 16.2" in peak_to_peak


def test_half_a_cycle_with_an_inverted_force_is_flagged() -> None:
    t = 0.01 * np.arange(100)
    x = 0.01 * np.sin(3.0 * t)
    record = Record(t, x, -500.0 * np.gradient(x, t), name="half")
    assert "half: its loops create energy" in disagreements(record)[0]
    assert disagreements(record.replace(note="turned", force=-record.force)) == []
