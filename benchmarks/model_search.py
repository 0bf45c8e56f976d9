"""The search of models on the campaign in CPU time, its kernels compiled before, beside one validation of its winner."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks._lines import Line
from dampyr.errors import DampyrWarning
from dampyr.identification import FitOptions, fit
from dampyr.identification.scoring.validation import cross_validate
from dampyr.records import read_campaign

TITLE = "The search of models, 38 records of the campaign, one process, kernels compiled before: CPU time"
PARTS = 5  # that are left out in turn


def run(data: Path | None) -> list[Line] | str:
    """The search twice, the first of which compiles what is not there, and its winner alone, without each of its parts."""
    folder = data / "labcontrol-mr-damper" if data else None
    if folder is None or not folder.is_dir():
        return "the campaign's files are not on this machine; `dampyr datasets fetch labcontrol` gets them"
    records = read_campaign(folder, role="fit")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        board = fit(records).leaderboard
        options = FitOptions(bandwidth=board.bandwidth, folds=PARTS, steps=300)
        alone = _cpu(lambda: cross_validate(records, board.winner.model, options=options))
        search = _cpu(lambda: fit(records))
    tried = sum(len(model.trials) for model in board.screened)
    words = f"{tried} trials, {len(board.entries)} finalists: {board.winner.model}, {100 * board.winner.error:.2f} %"
    return [
        Line(f"the winner alone, {PARTS} parts left out in turn", alone, alone, 1),
        Line("the search", search, search, 1, words),
    ]


def _cpu(call: Callable[[], Any]) -> float:
    """CPU time of a call, s."""
    begun = time.process_time()
    call()
    return time.process_time() - begun
