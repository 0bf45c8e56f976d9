"""Differences between what a folder was begun with and what is asked of it now: campaign, motion and settings."""

import json
import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from tests.campaigns.quick_rig import FIRST, QUAKE, QUICK, SECOND, TWO_SINES, motion, quick_rig

from dampyr import records
from dampyr.campaigns import perform, read_journal
from dampyr.campaigns.journal import Journal
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.rig import simulated


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("cycles = 1", "cycles = 2"), f"{FIRST}: cycles was 1, is 2; {SECOND}: cycles was 1, is 2"),
        (('rest_before = "0.2 s"', 'rest_before = "0.3 s"'), f"{FIRST}: rest_before was 0.2 s, is 0.3 s"),
        (('"0 V", "1 V"', '"0 V"'), "02-sine-4mm-1Hz-1V is not in it any more"),
        (('"0 V", "1 V"', '"1 V", "0 V"'), "is not in it any more; .* is new in it"),
        (('rest_between = "0.1 s"', 'rest_between = "0.1 s"\nseed = 3\norder = "random"'), "another order"),
    ],
)
def test_another_campaign_is_told_what_differs(lab: Path, change: tuple[str, str], words: str) -> None:
    (lab / "short.toml").write_text(TWO_SINES.replace(*change))
    with pytest.raises(InputError, match=rf"holds the campaign 'short', and this one differs: .*{words}"):
        perform(lab / "short.toml", quick_rig(), lab / "out")
    (lab / "out/journal.sqlite").unlink()
    with pytest.raises(FileError, match="is not of the campaign 'short'"):
        perform(lab / "short.toml", quick_rig(), lab / "out")


def test_a_campaign_with_its_motion_goes_on_where_it_was_moved_to_and_not_with_another_motion(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir()
    (old / "quake.toml").write_text(QUAKE)
    motion(old / "motion.csv", 1.0)
    perform(old / "quake.toml", quick_rig(), old / "out")
    old.rename(new)
    opened = quick_rig()
    perform(new / "quake.toml", opened, new / "out")
    assert opened.board.simulator.time == 0.0
    shutil.copy(new / "out/journal.sqlite", tmp_path)
    (new / "out/journal.sqlite").unlink()
    with pytest.warns(DampyrWarning, match="1 complete, 0 not"):
        perform(new / "quake.toml", quick_rig(), new / "out")
    motion(new / "motion.csv", 1.5)
    with pytest.raises(
        InputError, match=r"this one differs: 01-earthquake.*: the file of its motion holds something else"
    ):
        perform(new / "quake.toml", quick_rig(), new / "out")
    (new / "out/journal.sqlite").unlink()
    with pytest.raises(FileError, match="what is in its files differ"):
        perform(new / "quake.toml", quick_rig(), new / "out")


def test_settings_that_were_changed_are_told_and_kept_with_each_record(lab: Path) -> None:
    changed = replace(
        QUICK,
        load_cell=replace(QUICK.load_cell, scale=700.0),
        encoder=replace(QUICK.encoder, count=1e-5),
    )
    words = r"encoder\.count was 0\.005 mm, is 0\.01 mm; load_cell\.scale was 613 N/V, is 700 N/V"
    opened = simulated(changed)
    perform(lab / "short.toml", opened, lab / "out")  # nothing is left: nothing is told
    with pytest.warns(DampyrWarning, match=f"settings differ from those that the campaign was begun with: {words}"):
        perform(lab / "short.toml", opened, lab / "out", again=[SECOND])
    first, second = records.read_campaign(lab / "out")
    assert "rig_changes" not in first.provenance
    assert second.provenance["rig_changes"].startswith("encoder.count was 0.005 mm")
    assert [event.what for event in read_journal(lab / "out")[1]].count("settings changed") == 1
    (lab / "out/journal.sqlite").unlink()  # the first record's settings are those that it was begun with
    with pytest.warns(DampyrWarning, match="made anew"), pytest.warns(DampyrWarning, match=words):
        perform(lab / "short.toml", simulated(changed), lab / "out", again=[FIRST])
    with closing(Journal(lab / "out")) as journal:
        assert json.loads(journal.get_metadata("rig"))["load_cell"]["scale"] == 613.0
