"""Specimen of a rig: the card that its settings name, and the fit to the original rig's damper."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from dampyr.models import Damper, published
from dampyr.rig.settings import RigSettings

CARD = Path(__file__).with_name("original_specimen.toml")


@cache
def original_specimen() -> Damper:
    """The fit to the records of the original campaign: hyperbolic tangent, spring and offset over 0 to 3.212 V.

    F = f0 + k0 x + c v + ft tanh((v + s x)/v0), its laws through the fits at 0, 0.8712, 1.98 and 3.212 V; residual 8-11 %
    rms of the measured force.
    """
    return Damper.load(CARD)


def specimen_of(settings: RigSettings, folder: str | Path | None = None) -> Damper:
    """The damper that the settings name, without a card the original one; a relative card is in ``folder``.

    In place of a card the name of a set of `dampyr.models.published` will do.
    """
    card = settings.specimen.card
    return published.card_or_published(card, folder) if card else original_specimen()
