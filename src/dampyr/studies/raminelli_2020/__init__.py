"""Raminelli (2020), run again on its own raw data: the published value beside ours, and a verdict on each.

J. G. Raminelli, "Plataforma de testes dinâmicos para amortecedores magneto-reológicos e representação através de modelos
de histerese", master's dissertation, UTFPR, Cornélio Procópio, 2020.

`damper` is its damper, the cubics (4.6)-(4.8); `reproduce` runs every table, equation with numbers and figure with data.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.studies._compared_value import ComparedValue
from dampyr.studies.raminelli_2020.published import PUBLISHED, Published

if TYPE_CHECKING:
    from dampyr.models import Damper
    from dampyr.structures import Building
    from dampyr.studies.raminelli_2020.study import Progress, Study

__all__ = ["PUBLISHED", "STRUCTURES", "ComparedValue", "Published", "damper", "reproduce"]


def _building() -> Building:
    from dampyr import structures

    return structures.two_storey()


STRUCTURES = {"raminelli_2020": _building}
"""The building of chapter 5, by its name on the command line."""


def damper(published: Published = PUBLISHED) -> Damper:
    """The published damper: the viscous Dahl model with the cubics (4.6)-(4.8) over the voltage, in SI.

    Calibrated from 0 to 3.212 V (printed as 3.21); other voltages are extrapolated only where asked for by name.
    """
    from dampyr.studies.raminelli_2020.cubics import published_damper

    return published_damper(published)


def reproduce(
    data: str | Path | None = None,
    out: str | Path | None = None,
    published: Published = PUBLISHED,
    progress: Progress | None = None,
) -> Study:
    """Run the dissertation again.

    Parameters
    ----------
    data
        The folder of the campaign (or the one that holds it); by default where the data set "labcontrol" is on this machine.
        Where it is not, all that needs no data is done and ``Study.left_out`` says what was not.
    out
        Where to write ``reproduce.html`` and ``reproduce.json``; None writes nothing.
    published
        The numbers to compare with.
    progress
        Called with a stage and how much of it is done, 0 to 1.

    Raises
    ------
    MissingData
        ``data`` was given, and the campaign is not there.
    FileError
        A file of the campaign is not what its table says.
    """
    from dampyr.studies.raminelli_2020.study import run
    from dampyr.studies.raminelli_2020.study_page import write

    say = progress or (lambda stage, done: None)
    study = run(data, published, say)
    say("writing the page", 0.0)
    written = study if out is None else write(study, Path(out))
    say("writing the page", 1.0)
    return written
