"""The list of records: a file that cannot be read stands in its place, and what was read is not read again."""

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor

import pytest

pytest.importorskip("fastapi")
from tests.console.memory import resident
from tests.console.record_files import CSV, unfolding

from dampyr.console.record_list import RecordList
from dampyr.errors import InputError


def test_one_file_that_unfolds_does_not_hide_the_others(client, data):
    """Each is read where memory is bounded, and what cannot be is said in its place."""
    for name, content in (("a.csv", CSV.encode()), ("b.h5", unfolding()), ("c.csv", CSV.encode())):
        (data / name).write_bytes(content)
    before = resident()
    listed = client.get("/api/records/list").json()
    assert [(one["key"], bool(one["problem"])) for one in listed] == [
        ("data/a.csv", False), ("data/c.csv", False), ("data/b.h5", True)
    ]  # fmt: skip
    assert "memory" in listed[2]["problem"]
    assert resident() - before < 30


class Asked:
    """Workers that note which keys they were asked for, and refuse what is called "large"."""

    def __init__(self):
        self.keys = []

    async def each(self, request, limits, function, items, *arguments):
        self.keys.append(items)
        return [InputError("it takes more memory than allowed") if "large" in key else {"about": key} for key in items]


def test_what_was_described_is_read_again_only_when_its_file_changes(data):
    for name in ("a.csv", "large.csv"):
        (data / name).write_text(CSV)
    records, workers, keys = RecordList(), Asked(), ["data/a.csv", "data/large.csv"]

    def described():  # in a thread of its own: a browser of an earlier test leaves a loop running in this one
        with ThreadPoolExecutor(1) as pool:
            return pool.submit(asyncio.run, records.describe(workers, None, data, [*keys, "data/gone.csv"])).result()

    answer = described()
    assert answer == {"data/a.csv": {"about": "data/a.csv"}, "data/large.csv": answer["data/large.csv"]}
    assert "more memory" in answer["data/large.csv"]["problem"]
    assert described() == answer
    assert workers.keys == [keys]
    os.utime(data / "a.csv", ns=(1, 1))
    assert described() == answer
    assert workers.keys == [keys, ["data/a.csv"]]
