"""The kernels as plain Python: the generated text and the drivers as they are written, so that nothing is compiled."""

import pytest

from dampyr.models import path_integration
from dampyr.models.codegen import kernels


def run_as_plain_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """Until the test ends."""
    monkeypatch.setattr(kernels, "jit", lambda function, *_, **__: function)
    monkeypatch.setattr(kernels, "_shared", {})
    for name in ("bind", "_bound"):  # without their memory, which would hand these functions to later tests
        monkeypatch.setattr(kernels, name, getattr(kernels, name).__wrapped__)
    monkeypatch.setattr(path_integration, "bind", kernels.bind)
