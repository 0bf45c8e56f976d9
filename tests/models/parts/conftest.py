"""Short paths need no compiled kernels: a composition of its own takes seconds to compile."""

import pytest
from tests.models.plain_kernels import run_as_plain_python


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernels as plain Python."""
    run_as_plain_python(monkeypatch)
