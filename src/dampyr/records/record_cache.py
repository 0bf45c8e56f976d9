"""What is worked out of a record once: records never change, and every package asks for their cycles and their findings."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from dampyr.records.record import Record

Answer = TypeVar("Answer")


def cached_by_record(function: Callable[[Record], Answer]) -> Callable[[Record], Answer]:
    """``function``, called once for each record, as long as the record lives; what it returns must not be changed."""
    answers: WeakKeyDictionary[Record, Answer] = WeakKeyDictionary()

    @wraps(function)
    def answer(record: Record) -> Answer:
        if record not in answers:
            answers[record] = function(record)
        return answers[record]

    return answer
