"""The study of the simulated rig beside the original one."""

from pathlib import Path

import pytest

from dampyr.errors import DampyrError
from dampyr.studies import rig_resemblance


@pytest.mark.prove
def test_each_drive_has_its_record_and_its_numbers(campaign_folder: Path, tmp_path: Path) -> None:
    pairs = rig_resemblance.pairs(campaign_folder)
    assert [(p.voltage, p.top) for p in pairs] == [(v, t) for v in rig_resemblance.SLOPES for t in rig_resemblance.TOPS]
    rows = rig_resemblance.table(pairs)
    assert len(rows) == 8 * len(pairs)
    for row in rows:
        if row["what"] in ("stroke", "peak speed", "force span", "period"):
            assert row["simulated"] == pytest.approx(row["measured"], rel=0.25)
    fig = rig_resemblance.figure(pairs)
    assert len(fig.axes) == 8
    assert all(len(axes.get_lines()) == 2 for axes in fig.axes)


def test_one_drive_has_its_record_and_its_numbers(campaign_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig_resemblance, "SLOPES", {1.98: rig_resemblance.SLOPES[1.98]})
    monkeypatch.setattr(rig_resemblance, "TOPS", rig_resemblance.TOPS[:1])
    [pair] = rig_resemblance.pairs(campaign_folder)
    assert (pair.voltage, pair.top) == (1.98, rig_resemblance.TOPS[0])
    rows = {row["what"]: row for row in rig_resemblance.table([pair])}
    assert len(rows) == 8
    for name in ("stroke", "peak speed", "force span", "period"):
        assert rows[name]["simulated"] == pytest.approx(rows[name]["measured"], rel=0.25)


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DampyrError):
        rig_resemblance.pairs(tmp_path)
