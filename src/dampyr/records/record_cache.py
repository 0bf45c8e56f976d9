"""What is worked out of a record once: records never change, and every package asks for their cycles and their findings."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

from dampyr.records.record import Record

Answer = TypeVar("Answer")
Others = ParamSpec("Others")


def cached_by_record(
    function: Callable[Concatenate[Record, Others], Answer],
) -> Callable[Concatenate[Record, Others], Answer]:
    """``function``, called once for each record, as long as the record lives; what it returns must not be changed.

    Of a function with further arguments the answer to the latest ones is kept.
    """
    answers: WeakKeyDictionary[Record, tuple[object, Answer]] = WeakKeyDictionary()

    @wraps(function)
    def answer(record: Record, *others: Others.args, **named: Others.kwargs) -> Answer:
        asked = (others, tuple(sorted(named.items())))
        kept = answers.get(record)
        if kept is None or kept[0] != asked:
            kept = answers[record] = asked, function(record, *others, **named)
        return kept[1]

    return answer
