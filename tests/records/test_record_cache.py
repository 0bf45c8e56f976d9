"""What is worked out of a record once: for each record of its own, and only as long as it lives."""

import gc
import weakref

import numpy as np

from dampyr.records import Record
from dampyr.records.record_cache import cached_by_record


def record() -> Record:
    t = 0.01 * np.arange(10)
    return Record(t, t, t)


def test_a_question_is_answered_once_for_each_record() -> None:
    asked: list[Record] = []

    @cached_by_record
    def number(record: Record) -> int:
        """Of the records that were asked about."""
        asked.append(record)
        return len(asked)

    first, second = record(), record()  # of equal values
    assert [number(first), number(second), number(first), number(second)] == [1, 2, 1, 2]
    assert number(first.replace(note="another")) == 3
    assert number.__doc__ == "Of the records that were asked about."


def test_an_answer_keeps_no_record_alive() -> None:
    @cached_by_record
    def duration(record: Record) -> float:
        return record.duration

    asked = record()
    duration(asked)
    place = weakref.ref(asked)
    del asked
    gc.collect()
    assert place() is None
