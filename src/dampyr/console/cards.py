"""The cards of dampers in the data folder."""

from __future__ import annotations

from fastapi import APIRouter

from dampyr.console import safe_paths
from dampyr.console.dampers import CARDS
from dampyr.console.state import CurrentApp

router = APIRouter(tags=["Cards"])


@router.get("/cards")
def list_cards(app: CurrentApp) -> list[str]:
    """The cards of dampers in the folder ``cards`` of the data folder, by their names."""
    return safe_paths.files(app.data / CARDS, (".toml",))
