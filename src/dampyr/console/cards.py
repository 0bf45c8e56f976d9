"""The cards of dampers in the data folder."""

from __future__ import annotations

from fastapi import APIRouter

from dampyr.console import places
from dampyr.console.house import Here

CARDS = "cards"

router = APIRouter(tags=["Cards"])


@router.get("/cards")
def list_cards(here: Here) -> list[str]:
    """The cards of dampers in the folder ``cards`` of the data folder, by their names."""
    return places.files(here.data / CARDS, (".toml",))
