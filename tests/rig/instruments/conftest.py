"""A folder with the page's instruments, and the records of the usual board."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.rig.instruments.laboratory import FILE, PAGE, records_of

from dampyr.records import Record
from dampyr.rig import simulated


@pytest.fixture
def laboratory(tmp_path: Path) -> Path:
    """The folder of a rig.toml with the page's instruments."""
    for name, text in FILE.findall(PAGE):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, "utf-8")
    return tmp_path


@pytest.fixture(scope="session")
def usual(tmp_path_factory: pytest.TempPathFactory) -> list[Record]:
    """The records of the NI board."""
    return records_of(simulated(), tmp_path_factory.mktemp("usual") / "out")
