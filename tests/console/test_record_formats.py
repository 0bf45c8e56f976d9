"""Formats of records that the console offers are those that the library has."""

import pytest

pytest.importorskip("fastapi")

from dampyr import registry


def test_formats_of_records_are_all_of_them(client):
    formats = client.get("/api/records/formats").json()
    members = dict(registry.members("dampyr.records.formats"))
    assert [one["name"] for one in formats["read"]] == list(members)
    writers = [name for name, module in members.items() if hasattr(module, "write")]
    assert [one["name"] for one in formats["written"]] == sorted([*writers, "png"])
    assert {"HDF5", "CSV", "PNG"} <= {one["title"] for one in formats["written"]}
