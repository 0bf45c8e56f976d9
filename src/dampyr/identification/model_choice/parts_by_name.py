"""Parts that a search of models leaves out unless they are named: a fit at one input tells which the records call for.

Each has a reason to be left out (`dampyr.models.part.Part.not_tried`), and costs more than most. So after the screening each is
fitted to the screened records of the middle input, and so is the best of the models that were tried; a part that leaves
`CALLED_FOR` or less of what that leaves is screened like the others, with the search's add-ons.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.least_squares import fit_model
from dampyr.identification.model_choice import parallel
from dampyr.identification.model_choice.parameter_laws import list_held
from dampyr.models.part import part
from dampyr.phrases import percent
from dampyr.records import Record

CALLED_FOR = 0.6  # of the misfit of the best of the others: a part that leaves more is not what is missing
STEPS = 40  # of each fit


@dataclass(frozen=True)
class CalledPart:
    """A part that is tried unnamed: the mean L1 ratio at one input with it, and without: of the best other model, ``model``."""

    name: str
    l1: float
    model: str
    without: float

    def __str__(self) -> str:
        return (
            f"{self.name} was tried too, as at one input it leaves {percent(self.l1)} where {self.model} leaves "
            f"{percent(self.without)}; mind that {part(self.name).not_tried}"
        )


def find_called_parts(
    names: Sequence[str],
    best: str,
    small: Sequence[Record],
    options: FitOptions,
    executor: Executor | None,
    progress: Callable[[float], None],
    deadline: float = math.inf,
) -> tuple[list[CalledPart], float]:
    """Which of the parts ``names`` the records call for beside the ``best`` model of the screening set ``small``, and the work
    of finding out, counted s. None where ``deadline``, a value of ``time.monotonic`` in s, left some of it undone."""
    inputs = sorted({float(record.input_value or 0.0) for record in small})
    middle = inputs[len(inputs) // 2]
    records = [record for record in small if float(record.input_value or 0.0) == middle]
    options = replace(options, laws=None, fixed={}, tied={}, add_ons=(), steps=STEPS)
    jobs = [partial(_misfit, model, records, options) for model in (best, *names)]
    done = parallel.run_all(jobs, executor, progress, deadline=deadline)
    if any(result is None for result in done):
        return [], 0.0
    (without, _), *others = done
    called = [
        CalledPart(name, l1, best, without)
        for name, (l1, _) in zip(names, others, strict=True)
        if l1 <= CALLED_FOR * without
    ]
    return called, sum(work for _, work in done)


def _misfit(model: str, records: Sequence[Record], options: FitOptions) -> tuple[float, float]:
    """The mean L1 ratio of the records that a model is fitted to, infinite without a fit, and the work, counted s."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)  # of a model that is only tried
            result = fit_model(model, records, replace(options, fixed=list_held(model)))
            l1 = float(np.mean([score.l1 for score in result.scores.values()]))
    except (InputError, np.linalg.LinAlgError, FloatingPointError):
        return math.inf, 0.0
    return (l1 if np.isfinite(l1) else math.inf), result.outcome.work
