"""Acceptance of many records as one job: records and a reference in, one verdict and those of the records out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from dampyr.argument_kinds import DAMPER, RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import OF_DAMPER, Finding, as_dicts, handed_on, worst_first
from dampyr.identification.acceptance_tests.acceptance import (
    QUANTITIES,
    Acceptance,
    AcceptancePlots,
    Quantity,
    Tolerance,
    Verdict,
    accept,
    in_short,
    relevelled,
    used_of_band,
)
from dampyr.models import Damper
from dampyr.origin import Origin, combined
from dampyr.records import Record, nominal_inputs
from dampyr.representation import Representation, Summary, Table, data_frame
from dampyr.to_json import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
class Accepted(Representation):
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
    def plot(self) -> AcceptancePlots:
        """Figures of all records: ``accepted.plot.forces()`` and ``.used()``, each giving matplotlib axes."""
        return AcceptancePlots(self.results)

    def to_dataframe(self) -> Any:
        """The judgement of each record as a ``pandas.DataFrame``; ``worst_deviation`` is a ratio."""
        columns = {
            "input": [one.input_value for one in self.results],
            "verdict": [one.verdict for one in self.results],
            "run": [one.run for one in self.results],
            "cut": [one.cut for one in self.results],
            "judged_cycles": [one.judged_cycles for one in self.results],
            "judged_stroke_m": [one.judged_stroke_m for one in self.results],
            "points": [len(one.points) for one in self.results],
            "judged": [len(one.judged) for one in self.results],
            "outside": [len(one.outside) for one in self.results],
            "worst_deviation": [one.worst.deviation if one.worst else None for one in self.results],
            "wrong_rejection": [one.wrong_rejection for one in self.results],
            "wrong_acceptance": [one.wrong_acceptance for one in self.results],
        }
        return data_frame(columns, [one.record for one in self.results], "record")

    def _small_figure(self) -> Figure | None:
        from dampyr.figures.acceptance import band_used

        judged = [one for one in self.results if one.judged]
        used, outside = used_of_band(judged)
        return band_used(used, outside=outside) if judged else None

    def _summary(self) -> Summary:
        rows = [("verdict", self.verdict), ("records", in_short(self.results))]
        if self.results:
            rows.append(("band", f"{self.results[0].tolerance}, judged by {', '.join(self.results[0].quantities)}"))
        return f"Accepted by {self.reference!r}", rows

    def _table(self) -> Table:
        rows = [
            [one.record, one.verdict, one.run, one.cut, one.judged_cycles, 1e3 * one.judged_stroke_m, len(one.outside),
             None if one.worst is None or one.worst.deviation is None else 100 * one.worst.deviation]
            for one in self.results
        ]  # fmt: skip
        return ("record", "verdict", "run", "cut", "judged", "judged to [mm]", "outside", "worst off by [%]"), rows

    @property
    def verdict(self) -> Verdict:
        """The verdict of all: failed where one failed, not judged where one was not, else passed."""
        verdicts = {one.verdict for one in self.results}
        order: tuple[Verdict, ...] = ("failed", "not judged", "passed")
        return next(each for each in order if each in verdicts)

    def as_dict(self) -> dict[str, Any]:
        """All results for JSON, SI units."""
        records = [one.as_dict() for one in self.results]
        more = {"relevelled": [one.as_dict() for one in self.relevelled]} if self.relevelled else {}
        answer = {
            "reference": self.reference,
            "origin": self.origin.as_dict(),
            "verdict": self.verdict,
            "findings": as_dicts(self.findings),
            "records": records,
        }
        return dict(plain(answer | more))


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
