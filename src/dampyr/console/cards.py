"""The cards of dampers in the data folder."""

from __future__ import annotations

from fastapi import APIRouter

from dampyr.console import safe_paths
from dampyr.console.dampers import CARDS
from dampyr.console.state import Here

router = APIRouter(tags=["Cards"])


@router.get("/cards")
def list_cards(here: Here) -> list[str]:
    """The cards of dampers in the folder ``cards`` of the data folder, by their names."""
    return safe_paths.files(here.data / CARDS, (".toml",))
