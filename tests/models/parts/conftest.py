"""Short paths need no compiled kernels: a composition of its own takes seconds to compile."""

import pytest
from tests.models.plain_kernels import run_as_plain_python


@pytest.fixture(params=["plain", pytest.param("compiled", marks=pytest.mark.prove)])
def plain(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """The kernels as plain Python, and in a proof as they are compiled."""
    if request.param == "plain":
        run_as_plain_python(monkeypatch)
