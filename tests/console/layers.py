"""What lies behind the layers that guard a console."""

from __future__ import annotations

from typing import Any


def state_of(console: Any) -> Any:
    """The state of a console that `dampyr.console.app` has made."""
    while hasattr(console, "app"):
        console = console.app
    return console.state.dampyr
