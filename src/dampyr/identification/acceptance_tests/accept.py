"""Acceptance as one job: `accept` takes records and a reference, and gives one verdict and those of the records."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from dampyr.argument_kinds import DAMPER, RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import OF_DAMPER, Finding, handed_on, worst_first
from dampyr.identification.acceptance_tests.acceptance import (
    Acceptance,
    AcceptOptions,
    Verdict,
    judge_record,
    relevelled,
)
from dampyr.models import Damper
from dampyr.options import takes
from dampyr.origin import Origin, combined
from dampyr.records import Record, nominal_inputs
from dampyr.records.files.campaign_folder import RecordsOrPaths, as_records
from dampyr.shown import Shown


@dataclass(frozen=True, repr=False)
class Accepted(Shown):
    """Result of `accept`: the judgement of each record; ``reference`` is what the reference is called.

    ``records`` were judged, ``reference_records`` are those of a reference that is no card; ``findings`` are what is wrong or
    in doubt in the reference's card and in all these records.
    """

    reference: str
    results: tuple[Acceptance, ...]
    records: tuple[Record, ...] = ()
    reference_records: tuple[Record, ...] = ()
    relevelled: tuple[Acceptance, ...] = ()
    findings: tuple[Finding, ...] = ()

    @property
    def origin(self) -> Origin:
        """That of the records and of the reference together."""
        return combined(result.origin for result in self.results)

    @property
    def verdict(self) -> Verdict:
        """The verdict of all: failed where one failed, not judged where one was not, else passed."""
        verdicts = {result.verdict for result in self.results}
        order: tuple[Verdict, ...] = ("failed", "not judged", "passed")
        return next(verdict for verdict in order if verdict in verdicts)


@takes(AcceptOptions)
def accept(
    records: RecordsOrPaths,
    reference: Damper | Record | Sequence[Record],
    options: AcceptOptions | None = None,
    name: str = "the reference",
    progress: Callable[[str, float], None] | None = None,
    **keywords: Any,
) -> Accepted:
    """Judge every whole cycle of every level of records by a reference.

    Measured inputs that are constant but for noise count as constants, those close to an input of the reference as that one.
    From the forces of every record, and of the damper's run, its own mean over the cycles of its levels is taken, since a load
    cell's zero and the gas force are not the damper's work. A force that is larger in one direction only moves that mean, so
    half of the excess shows in each direction; where the zero is known, give it: ``offset`` is then taken from the measured
    forces, and a damper's force stays as it is. With ``relevel`` each record is judged a second time, its forces over the level
    of that many first cycles (``relevelled`` of the result). What lies beyond the calibrated range is judged with a warning
    where ``allow_extrapolation`` is given.

    Parameters
    ----------
    records
        one record, or several; or the files or folders that hold them.
    reference
        a damper, which runs freely along each record's own motion and input, both forces being read by the same cycles; or one
        record or several of a reference damper at the same input, whose points are interpolated over speed in each direction,
        and whose energies are compared where the strokes agree to 10 % (the record itself among them is left out).
    options
        the further arguments as one object; those that are given by name take their places.
    name
        what the reference is called.
    progress
        called with what is being done, and the fraction of it that is done.

    Returns
    -------
    Accepted
        one `Acceptance` for each record in ``results``; what cannot be judged is a value with a reason.

    Raises
    ------
    InputError
        arguments of the wrong kind or in the wrong order, no records, a band without a width, records of mixed inputs.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, 1.1 * damper.force(t, x, voltage=1.98), voltage=1.98)
    >>> dp.identification.accept(record, damper).verdict, dp.identification.accept(record, damper, tolerance="5 %").verdict
    ('passed', 'failed')
    """
    records = as_records(records)
    check_kinds(
        "accept",
        Argument("records", records, (Record,), RECORDS, several=True),
        Argument("reference", reference, (Damper, Record), DAMPER, several=True),
    )
    options = AcceptOptions.of("accept", options, keywords)
    judged = list(records)
    if not judged:
        raise InputError("there are no records to judge; give one or more")
    against: Damper | list[Record]
    if isinstance(reference, Damper):
        against = reference
    elif not (against := nominal_inputs([reference] if isinstance(reference, Record) else reference)):
        raise InputError("there are no records of a reference; give a Damper, a Record or a list of records")
    results = []
    for k, record in enumerate(nominal_inputs(judged, inputs_of(against))):
        if progress:
            progress("judging", k / len(judged))
        results.append(judge_record(record, against, options))
    again = tuple(relevelled(result, options.relevel) for result in results) if options.relevel else ()
    others = () if isinstance(against, Damper) else tuple(against)
    of_records = handed_on((*judged, *others))
    of_card = handed_on([against], OF_DAMPER, of_records) if isinstance(against, Damper) else ()
    findings = worst_first(of_card, of_records)
    return Accepted(name, tuple(results), tuple(judged), others, again, findings)


def inputs_of(reference: Damper | Sequence[Record]) -> Sequence[float]:
    """The inputs that a reference says something of: the ends of a damper's range, or those of its records."""
    if isinstance(reference, Damper):
        return reference.range
    return sorted({record.input_value for record in reference if record.input_value is not None})
