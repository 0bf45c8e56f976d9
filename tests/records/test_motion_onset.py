"""The rest is found on encoder steps, noise and records that move at once."""

import numpy as np
import pytest

from dampyr.records import Record, motion_start, read_campaign


@pytest.mark.parametrize(
    "fault", [{}, {"noise": 2e-5}, {"drift": 5e-4}, {"quantum": 0.0}, {"amplitude": 2.5e-3}], ids=str
)
@pytest.mark.parametrize("rest", [0.0, 0.37, 2.0, 4.0])
def test_the_start_is_found_to_two_samples(make_sine, rest, fault):
    assert motion_start(make_sine(rest=rest, **fault)) == pytest.approx(rest, abs=0.0201)


def test_one_encoder_step_during_the_rest_is_no_motion(make_sine):
    record = make_sine()
    x = record.displacement.copy()
    x[50:120] += 5e-6
    assert motion_start(record.replace(note="flicker", displacement=x)) == pytest.approx(2.0, abs=0.02)


def test_an_encoder_that_settles_by_one_step_is_no_motion(make_sine):
    record = make_sine(rest=11.0)
    x = record.displacement.copy()
    x[50:] += 5e-6
    assert motion_start(record.replace(note="settled", displacement=x)) == pytest.approx(11.0, abs=0.02)


def test_a_record_that_never_moves_starts_at_its_end():
    t = 0.01 * np.arange(50)
    assert motion_start(Record(t, np.zeros(50), np.ones(50))) == t[-1]


def test_the_real_records(campaign_folder):
    start = {record.name: motion_start(record) for record in read_campaign(campaign_folder, role=None)}
    assert all(0 <= value <= 4.0 for value in start.values())
    assert sum(value > 1.95 for value in start.values()) == 13
    at_once = {name for name, value in start.items() if value <= 0.15}
    assert at_once == {"ensaio.A.3", "ensaio.A.8", "ensaio.A.9", "ensaio.B.7"}
