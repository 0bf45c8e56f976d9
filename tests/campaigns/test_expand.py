"""From a step to its tests: grids, lists row by row, and tables of rows."""

import pytest

from dampyr import campaigns
from dampyr.errors import FileError, InputError

SINE = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz"}


def read(*steps, **header):
    return campaigns.campaign_of({"step": list(steps), **header})


def names(campaign):
    return [test.name for test in campaign.tests]


def test_lists_make_a_grid_whose_first_list_changes_slowest():
    campaign = read(SINE | {"amplitude": ["5 mm", "8 mm"], "voltage": ["0 V", "1.98 V"]})
    assert [(t.step.amplitude, t.step.voltage) for t in campaign.tests] == [
        (0.005, 0.0), (0.005, 1.98), (0.008, 0.0), (0.008, 1.98),
    ]  # fmt: skip
    assert names(campaign)[3] == "04-sine-8mm-1Hz-1.98V"


def test_zipped_lists_are_taken_row_by_row():
    campaign = read(SINE | {"amplitude": ["5 mm", "8 mm"], "frequency": ["2 Hz", "1 Hz"], "zip": True})
    assert [(t.step.amplitude, t.step.frequency) for t in campaign.tests] == [(0.005, 2.0), (0.008, 1.0)]


def test_a_list_of_levels_is_one_test_and_a_list_of_lists_is_several():
    base = {"kind": "voltage_steps", "amplitude": "5 mm", "frequency": "1 Hz"}
    [one] = read(base | {"voltages": ["0 V", "1.98 V"]}).tests
    assert one.step.voltages == (0.0, 1.98)
    assert len(read(base | {"voltages": [["0 V"], ["1.98 V", "1 V"]]}).tests) == 2


def test_rows_come_from_a_table_beside(tmp_path):
    (tmp_path / "rows.csv").write_text("peak_to_peak [mm],frequency,cycles\n24.75,0.84 Hz,5\n\n10,1.2,6\n")
    (tmp_path / "c.toml").write_text('[[step]]\nkind = "sine"\nrows = "rows.csv"\nvoltage = [0, 1]\n')
    campaign = campaigns.read(tmp_path / "c.toml")
    rows = [(t.step.amplitude, t.step.frequency, t.step.cycles, t.step.voltage) for t in campaign.tests]
    assert rows == [(0.012375, 0.84, 5, 0.0), (0.012375, 0.84, 5, 1.0), (0.005, 1.2, 6, 0.0), (0.005, 1.2, 6, 1.0)]
    assert campaign.header.name == "c"


def test_tests_are_counted_before_any_is_built(tmp_path, monkeypatch):
    def built(*_):
        raise AssertionError("a test is built")

    monkeypatch.setattr("dampyr.campaigns.campaign._build_step", built)
    (tmp_path / "rows.csv").write_text("amplitude [mm]\n" + "8\n" * 1500)
    for table in (
        {"rows": "rows.csv", "repeats": 2},
        {"amplitude": [0.001] * 3000},
        {"amplitude": [0.001] * 3000, "zip": True},
    ):
        with pytest.raises(InputError, match="3,000 tests"):
            campaigns.campaign_of({"step": [{"kind": "sine", "frequency": 1.0, **table}]}, tmp_path)
    with pytest.raises(InputError, match=r"4 tests.*at most 3"):
        campaigns.campaign_of({"step": [{"kind": "rest", "duration": 1.0, "repeats": 2}] * 2}, max_tests=3)


def test_a_table_of_rows_has_a_size(tmp_path):
    (tmp_path / "rows.csv").write_text("amplitude [mm]\n" + "8\n" * 3_000_000)
    with pytest.raises(FileError, match="6 MiB; a table of rows has at most 4"):
        campaigns.campaign_of({"step": [{"kind": "sine", "frequency": 1.0, "rows": "rows.csv"}]}, tmp_path)


def test_a_field_stands_in_one_place(tmp_path):
    (tmp_path / "rows.csv").write_text("amplitude [mm],frequency\n8,1\n")
    with pytest.raises(InputError, match=r"step 1.amplitude stands in the step and in its table of rows"):
        campaigns.campaign_of({"step": [SINE | {"rows": "rows.csv"}]}, tmp_path)
