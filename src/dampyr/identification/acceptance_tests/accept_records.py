"""Acceptance of many records as one job: records and a reference in, one verdict and those of the records out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from dampyr.argument_kinds import DAMPER, RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import OF_DAMPER, Finding, handed_on, worst_first
from dampyr.identification.acceptance_tests.acceptance import (
    QUANTITIES,
    Acceptance,
    Quantity,
    Tolerance,
    Verdict,
    accept,
    relevelled,
)
from dampyr.models import Damper
from dampyr.origin import Origin, combined
from dampyr.records import Record, nominal_inputs
from dampyr.shown import Shown


@dataclass(frozen=True)
class AcceptOptions:
    """Options of `accept_records`; see `dampyr.identification.accept`. With ``relevel`` each record is judged a second
    time, its forces over the level of that many first cycles
    (`dampyr.identification.acceptance_tests.acceptance.relevelled`)."""

    tolerance: Tolerance = field(default_factory=Tolerance)
    quantities: tuple[Quantity, ...] = QUANTITIES
    offset: float | None = None
    allow_extrapolation: bool = False
    relevel: int = 0

    def __post_init__(self) -> None:
        if self.relevel < 0:
            raise InputError(f"relevel = {self.relevel} is not allowed; give the number of cycles, or 0")
        unknown = [each for each in self.quantities if each not in QUANTITIES]
        if unknown or not self.quantities:
            what = f"{unknown[0]!r} is not among the quantities" if unknown else "no quantity is given"
            raise InputError(f"{what}; choose from {', '.join(QUANTITIES)}")


@dataclass(frozen=True, repr=False)
class Accepted(Shown):
    """Result of `accept_records`: the judgement of each record; ``reference`` is what the reference is called.

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
        return combined(one.origin for one in self.results)

    @property
    def verdict(self) -> Verdict:
        """The verdict of all: failed where one failed, not judged where one was not, else passed."""
        verdicts = {one.verdict for one in self.results}
        order: tuple[Verdict, ...] = ("failed", "not judged", "passed")
        return next(each for each in order if each in verdicts)


def accept_records(
    records: Sequence[Record],
    reference: Damper | Sequence[Record],
    options: AcceptOptions | None = None,
    name: str = "the reference",
    progress: Callable[[str, float], None] | None = None,
) -> Accepted:
    """Judge every whole cycle of every level of every record by a damper, or by records of a reference damper.

    Measured inputs that are constant but for noise count as constants, those close to an input of the reference as that one.
    ``name`` is what the reference is called.
    """
    check_kinds(
        "accept_records",
        Argument("records", records, (Record,), RECORDS, several=True),
        Argument("reference", reference, (Damper, Record), DAMPER, several=True),
    )
    options = options or AcceptOptions()
    if not records:
        raise InputError("there are no records to judge; give one or more")
    against = reference if isinstance(reference, Damper) else nominal_inputs(reference)
    results = []
    for k, record in enumerate(nominal_inputs(records, inputs_of(against))):
        if progress:
            progress("judging", k / len(records))
        results.append(
            accept(record, against, options.tolerance, options.quantities, options.offset, options.allow_extrapolation)
        )
    again = tuple(relevelled(one, options.relevel) for one in results) if options.relevel else ()
    others = () if isinstance(against, Damper) else tuple(against)
    of_records = handed_on((*records, *others))
    of_card = handed_on([against], OF_DAMPER, of_records) if isinstance(against, Damper) else ()
    findings = worst_first(of_card, of_records)
    return Accepted(name, tuple(results), tuple(records), others, again, findings)


def inputs_of(reference: Damper | Sequence[Record]) -> Sequence[float]:
    """The inputs that a reference says something of: the ends of a damper's range, or those of its records."""
    if isinstance(reference, Damper):
        return reference.range
    return sorted({record.input_value for record in reference if record.input_value is not None})
