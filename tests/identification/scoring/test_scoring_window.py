"""Which samples are scored: after settling, over whole windows of an average, and enough of them."""

import pytest
from tests.identification.smoothed_records import smoothed
from tests.identification.synthetic import DAHL, sine

from dampyr.errors import InputError
from dampyr.identification import score
from dampyr.identification.scoring.scoring_window import list_unscorable, scoring_window, too_short
from dampyr.records import cut
from dampyr.records.checks.quality import motion_start


def test_the_window_starts_two_seconds_after_the_motion_and_is_told() -> None:
    record = sine(DAHL, 0.0)
    window = score(DAHL, record).window
    assert window.start == pytest.approx(motion_start(record) + 2.0, abs=record.dt)
    assert window.end == record.time[-1]
    assert scoring_window(record, settling=0.5).start < window.start


def test_a_window_without_samples_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"holds 0 samples; the record ends at 5\.99\d* s|holds 0 samples; the record ends"
    ):
        score(DAHL, sine(DAHL, 0.0), window=(50.0, 60.0))


def test_a_record_that_is_too_short_is_refused_with_its_numbers() -> None:
    record = sine(DAHL, 0.0, seconds=2.7)
    with pytest.raises(InputError, match=r"its motion lasts 2\.19 s .* give a settling of at most 1\.6 s"):
        score(DAHL, record)
    assert score(DAHL, record, settling=1.0).l1 < 1e-9
    assert list_unscorable([record, sine(DAHL, 0.0, "long")]).keys() == {"test"}
    with pytest.raises(InputError, match="no record is long enough to be scored; test: its motion"):
        list_unscorable([record])


def test_whole_windows_decide_whether_a_record_is_too_short() -> None:
    record = smoothed(sine(DAHL, 0.0, seconds=6.0), 41)
    end, start = float(record.time[-1]), motion_start(record)
    whole = end - 20 * record.dt - start
    assert not too_short(record, 0.74 * whole)
    reason = too_short(record, 0.76 * whole)
    assert f"its motion less what its moving average of 0.205 s leaves out lasts {whole:.3g} s" in reason
    assert not too_short(record.replace(note="", smoothed=None), 0.76 * whole)
    part = cut(record, 45 * record.dt)[0]
    assert "45 samples hold 5 with a whole window; give a longer record" in too_short(part)
