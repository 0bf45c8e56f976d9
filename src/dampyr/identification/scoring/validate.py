"""Validation of a card as one job: a damper and records in, scores of its predictions out."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from dampyr.argument_kinds import DAMPER, RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import OF_DAMPER, Finding, handed_on, worst_first
from dampyr.identification.scoring.prediction_band import LEVEL, Band, prediction_band, why_no_band
from dampyr.identification.scoring.score import Array, Score, compare, prediction
from dampyr.identification.scoring.scoring_window import SETTLING
from dampyr.identification.scoring.validation import mean_relevelled
from dampyr.models import Damper
from dampyr.models.prediction_error import check_level
from dampyr.options import Options, ShownIn, takes
from dampyr.origin import Origin, combined
from dampyr.phrases import listing
from dampyr.records import Record, nominal_inputs
from dampyr.records.files.campaign_folder import RecordsOrPaths, as_records
from dampyr.records.files.comparison import check_free, file_name, write_comparison
from dampyr.shown import Shown
from dampyr.units import Quantity


@dataclass(frozen=True)
class ScoreOptions(Options):
    """Options of `validate`."""

    settling: Annotated[float, Quantity("s", low=0), "Time after the motion starts that is not scored"] = SETTLING
    allow_extrapolation: Annotated[bool, "Predict at inputs that the card was not calibrated on, too"] = False
    band: Annotated[
        float | None,
        Quantity("", low=0, high=1, open_low=True),
        ShownIn("%"),
        "How much of each record's force its predictive band is to hold; none for no bands",
    ] = LEVEL
    session_prior: Annotated[
        float | None,
        Quantity("", low=0, high=1),
        ShownIn("%"),
        "How much the force differs from one measurement session to another, in the place of what the card states (standard "
        "deviation of the level)",
    ] = None

    def check(self) -> None:
        """Refuse a band of all of the force."""
        if self.band is not None:
            check_level(self.band, "band")


@dataclass(frozen=True, repr=False)
class Validated(Shown):
    """Result of `validate`: the scores by record, the predicted forces in N without the records' offsets, and the predictive
    ``bands`` by record, none where ``no_band`` says why."""

    card: str
    damper: Damper
    records: tuple[Record, ...]
    scores: Mapping[str, Score]
    forces: Mapping[str, Array]
    bands: Mapping[str, Band] = field(default_factory=dict)
    no_band: str = ""

    @property
    def origin(self) -> Origin:
        """That of the damper and the records together."""
        return combined([self.damper.origin, *(record.origin for record in self.records)])

    def measured_and_predicted(self, record: str | Record) -> tuple[Record, Array]:
        """A record, or the one of that name, and the force N that is predicted for it, with the record's offset."""
        names, name = [listed.name for listed in self.records], record if isinstance(record, str) else record.name
        if name not in names:
            raise InputError(f"{name!r} is not among the records; choose from {listing(names, 8)}")
        return self.records[names.index(name)], self.forces[name] + self.scores[name].offset

    @property
    def relevelled_l1(self) -> float:
        """The mean L1 ratio with the level that each record's first cycles have; NaN where no record has one."""
        return mean_relevelled(self.scores)

    @property
    def fitted_on(self) -> dict[str, bool | None]:
        """Whether the damper was fitted on each record, by the card; None where the card does not tell.

        A record whose file has the SHA-256 of one of the card's was fitted, whatever it is called; one that only shares its
        name with a record of the card, and whose file is another, may be either. A card without files is judged by names.
        """
        return {record.name: _was_fitted(self.damper, record) for record in self.records}

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the card and in the records; each once, the worst first."""
        of_records = handed_on(self.records)
        return worst_first(handed_on([self.damper], OF_DAMPER, of_records), of_records)

    @property
    def by_input(self) -> list[dict[str, Any]]:
        """Number of records, mean and worst L1 of each input, in rising order."""
        groups: dict[float | None, list[float]] = {}
        for record in self.records:
            groups.setdefault(record.input_value, []).append(self.scores[record.name].l1)
        order = sorted(groups, key=lambda u: math.inf if u is None else u)
        return [
            {
                "input": u,
                "records": len(groups[u]),
                "mean_l1": sum(groups[u]) / len(groups[u]),
                "worst_l1": max(groups[u]),
            }
            for u in order
        ]

    def write_forces(self, folder: str | Path) -> list[Path]:
        """Write NAME.csv with the measured and the predicted force of each record; other people's files are not replaced."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for record in self.records:
            check_free(folder / file_name(record))
        return [
            write_comparison(r, self.forces[r.name], folder / file_name(r), offset=self.scores[r.name].offset)
            for r in self.records
        ]


def _was_fitted(damper: Damper, record: Record) -> bool | None:
    listed = damper.provenance.get("records", "")
    names = {name.strip() for name in listed.split(",")} - {""}
    if len(names) == 1 and re.fullmatch(r"\d+ records", listed.strip()):  # too many to be named
        names = set()
    digests = {file.sha256 for file in damper.origin.sources}
    if record.source_file is not None and digests:
        if record.source_file.sha256 in digests:
            return True
        return None if record.name in names else False
    return record.name in names if names else None


@takes(ScoreOptions)
def validate(
    damper: Damper,
    records: RecordsOrPaths,
    options: ScoreOptions | None = None,
    card: str = "the damper",
    progress: Callable[[str, float], None] | None = None,
    **keywords: Any,
) -> Validated:
    """Score a damper on records that it predicts in a free run; only the offset is taken from each record.

    Measured inputs that are constant but for noise count as constants, those close to an end of the calibrated range as that
    end.

    Parameters
    ----------
    damper
        that is validated.
    records
        which it predicts, one or more; or the files or folders that hold them.
    options
        the further arguments as one object; those that are given by name take their places.
    card
        what the damper is called.
    progress
        called with what is being done, and the fraction of it that is done.

    Returns
    -------
    Validated
        scores, forces and predictive bands by record; ``no_band`` says why there are none of the latter.

    Raises
    ------
    InputError
        two records of one name, or an input outside of the calibrated range unless extrapolation is allowed.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, 1.1 * damper.force(t, x, voltage=1.98), voltage=1.98, name="stronger")
    >>> round(dp.identification.validate(damper, [record]).scores["stronger"].l1, 2)
    0.09
    """
    records = as_records(records)
    check_kinds(
        "validate",
        Argument("damper", damper, (Damper,), DAMPER),
        Argument("records", records, (Record,), RECORDS, several=True),
    )
    options = ScoreOptions.of("validate", options, keywords)
    if not records:
        raise InputError("there are no records to validate by; give one or more")
    if options.session_prior is not None:
        damper = damper.with_session_prior(options.session_prior)
    nominal = tuple(nominal_inputs(records, damper.range))
    name, count = Counter(record.name for record in nominal).most_common(1)[0]
    if count > 1:
        raise InputError(
            f"{count} records are called {name!r}; rename the files of all but one, or validate them one by one"
        )
    forces = {}
    for k, record in enumerate(nominal):
        if progress:
            progress("predicting", k / len(nominal))
        forces[record.name] = prediction(damper, record, options.allow_extrapolation)
    scores = {r.name: compare(r, forces[r.name], options.settling) for r in nominal}
    bands: dict[str, Band] = {}
    no_band = why_no_band(damper) if options.band is not None else ""
    if options.band is not None and not no_band:
        for k, record in enumerate(nominal):
            if progress:
                progress("drawing bands", k / len(nominal))
            try:
                bands[record.name] = prediction_band(
                    damper, record, options.band, options.settling, allow_extrapolation=options.allow_extrapolation
                )
            except InputError as problem:  # the scores stand without bands
                bands, no_band = {}, f"predictions have no band: {problem}"
                break
    return Validated(card, damper, nominal, scores, forces, bands, no_band)
