"""A part of the study: compared, what stands on the page, and slips of the text that it showed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dampyr.show.pages.blocks import Block
from dampyr.studies._compared_value import ComparedValue, Erratum


@dataclass(frozen=True)
class StudyPart:
    """What one chapter or artefact gave."""

    title: str
    compared: Sequence[ComparedValue]
    blocks: Sequence[Block]
    errata: Sequence[Erratum] = ()
