"""The study of the simulated rig beside the original one."""

from pathlib import Path

import pytest

from dampyr.errors import DampyrError
from dampyr.studies import rig_resemblance


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


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DampyrError):
        rig_resemblance.pairs(tmp_path)
