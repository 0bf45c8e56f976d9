"""The journal tells how far a campaign came, whoever was killed."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from dampyr.campaigns.journal import Journal, JournalEntry, read_journal
from dampyr.errors import FileError, InputError


def test_the_story_of_a_campaign(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.plan("d1", ["a", "b"], {"name": "first"})
    assert journal.begin("a") == 1
    journal.close()  # as a kill would
    journal = Journal(tmp_path)
    journal.plan("d1", ["a", "b"], {"name": "first"})
    assert [(t.name, t.state, t.attempt) for t in journal.tests()] == [("a", "running", 1), ("b", "planned", 0)]
    assert journal.begin("a") == 2
    journal.end("a", "complete")
    journal.begin("b")
    journal.end("b", "failed", "the motor stalled")
    journal.close()
    tests, events = read_journal(tmp_path)
    assert [(t.name, t.state, t.attempt, t.reason) for t in tests] == [
        ("a", "complete", 2, ""),
        ("b", "failed", 1, "the motor stalled"),
    ]
    assert [(e.test, e.attempt, e.what) for e in events] == [
        ("a", 1, "begun"),
        ("a", 2, "begun"),
        ("a", 2, "complete"),
        ("b", 1, "begun"),
        ("b", 1, "failed"),
    ]
    assert events[0].time.endswith("+00:00")


def test_another_campaign_in_the_folder_is_refused(tmp_path: Path) -> None:
    Journal(tmp_path).plan("d1", ["a"], {"name": "first"})
    with pytest.raises(InputError, match="holds the campaign 'first', and this one differs; give another --out"):
        Journal(tmp_path).plan("d2", ["a"], {"name": "second"})


def test_a_plan_begins_with_what_is_known_of_its_tests(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    assert journal.is_empty
    journal.plan("d1", ["a", "b"], {"name": "first"}, [JournalEntry("b", "complete", 3, "by its file")])
    assert not journal.is_empty
    assert journal.tests() == [JournalEntry("a", "planned", 0, ""), JournalEntry("b", "complete", 3, "by its file")]
    assert journal.begin("a", 4) == 5  # four tries have files
    assert journal.begin("b", 1) == 4


def test_a_disk_that_takes_no_entry_is_told(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.plan("d1", ["a"], {"name": "first"})
    journal._base.execute("PRAGMA query_only = ON")
    with pytest.raises(FileError, match=r"read-only \(.*\); make both writable, and run the campaign again"):
        journal.begin("a")
    journal._base.execute("PRAGMA query_only = OFF")
    journal._base.execute("PRAGMA max_page_count = 1")
    with pytest.raises(FileError, match=r"cannot be written \(.*full.*\); see to the disk, and run the campaign again"):
        journal.note("a", "b" * 200_000)
    journal._base.execute("PRAGMA max_page_count = 100000")
    assert journal.begin("a") == 1


def test_what_is_no_journal_is_told(tmp_path: Path) -> None:
    (tmp_path / "journal.sqlite").write_text("no journal at all " * 100)
    with pytest.raises(FileError, match="is not the journal of a campaign, or is broken"):
        Journal(tmp_path)
    with pytest.raises(InputError, match=r"has no journal.sqlite"):
        read_journal(tmp_path / "nowhere")


@pytest.mark.parametrize("how", ["CREATE TABLE tests(a)", "text", "schema"])
def test_what_is_no_journal_is_told_with_the_way_out(tmp_path: Path, how: str) -> None:
    if how == "text":
        (tmp_path / "journal.sqlite").write_text("not a database, and longer than its header of one hundred bytes" * 3)
    elif how == "schema":
        journal = Journal(tmp_path)
        journal.set_metadata({"schema": "abc"})
        journal.close()
    else:
        with closing(sqlite3.connect(tmp_path / "journal.sqlite")) as base:
            base.execute(how)
    with pytest.raises(FileError, match="move it away, and the same command makes it anew from the records"):
        Journal(tmp_path)
