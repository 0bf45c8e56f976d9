"""A campaign: what to run, read from a TOML file.

The names of its tests follow from the file alone, whatever the machine: ``03-sine-12.4mm-1.5Hz-0.8712V-r2`` is the third
test as written, second repeat.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from itertools import groupby
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from dampyr.campaigns.expand import Row, count_rows, expanded, read_rows
from dampyr.campaigns.kinds import kind as kind_of
from dampyr.campaigns.kinds import learning_steps, protocol_kind
from dampyr.campaigns.step import Length, shown, words
from dampyr.campaigns.steps.quasi_static import QuasiStatic
from dampyr.config import fill, load_toml, unknown, value_of
from dampyr.errors import DampyrError, FileError, InputError, MissingData
from dampyr.records.record import GROUPS, as_group
from dampyr.shown import Shown
from dampyr.units import Quantity, round_trip

ORDERS = ("as written", "random")
MAX_TESTS = 2000  # a day and a half at a minute each; more is most likely a slip in `repeats`
TABLE_KEYS = ("kind", "repeats", "zip", "rows", "learn")
"""What a ``[[step]]`` may say beside the fields of its kind."""


@dataclass(frozen=True)
class Header:
    """What stands above the steps."""

    name: Annotated[str, "name of the campaign; empty: that of its file"] = ""
    operator: Annotated[str, "person who answers for the campaign"] = ""
    note: Annotated[str, "remark that every record holds"] = ""
    measurement_session: Annotated[
        str, "name for one day's records on one mounting, in every record; empty: the day of the run and the specimen"
    ] = ""
    specimen: Annotated[str, "name of the damper that is tested, in every record; empty: as the rig's file says"] = ""
    seed: Annotated[int, "seed of the random order"] = 0
    order: Annotated[str, 'order of the tests, "as written" or "random"; warm-ups and rests keep their place'] = (
        "as written"
    )
    rest_between: Annotated[float, Quantity("s", low=0.0, high=3600.0), "rest from one test to the next"] = 5.0
    check_amplitude: Annotated[
        float, Quantity("m", low=0.0), "amplitude of a slow stroke before the first test; 0 leaves it out"
    ] = 0.002
    learn: Annotated[
        bool, "learn the drive of every test whose drive can be learned, unless its step says learn = false"
    ] = False

    def __post_init__(self) -> None:
        if self.order not in ORDERS:
            raise InputError(f"order = {self.order!r} is not known; choose from {', '.join(ORDERS)}")
        if self.seed < 0:
            raise InputError(f"seed = {self.seed} is not allowed; it must be at least 0")
        for name in GROUPS:
            if getattr(self, name):
                object.__setattr__(self, name, as_group(name, getattr(self, name)))


@dataclass(frozen=True, repr=False)
class Test(Shown):
    """One test: its place as written, the ``[[step]]`` that it comes from (from 1), and which of its repeats it is; ``learn``:
    its drive is learned before it is recorded."""

    __test__ = False

    number: int
    step_number: int
    kind: str
    step: Any
    repeat: int
    name: str
    learn: bool = False

    @property
    def words(self) -> str:
        """What it does, such as ``sine 20 mm at 2 Hz, 0.8712 V``."""
        return words(self.kind, self.step)

    @property
    def contents(self) -> dict[str, str]:
        """A hash of what is in each file that the step names, by its field."""
        return dict(getattr(self.step, "contents", {}))

    @property
    def additions(self) -> tuple[str, ...]:
        """What it is besides the fields that every release has had, where it is not as they were without: for the digest."""
        changed = [
            f"{field.name} = {getattr(self.step, field.name)!r}"
            for field in fields(self.step)
            if not field.repr and getattr(self.step, field.name) != field.default
        ]
        return (*changed, *(("learn",) if self.learn else ()))

    @property
    def where(self) -> str:
        """How a message begins: ``step 3, sine 20 mm at 2 Hz, 0 V``."""
        return f"step {self.step_number}, {self.words}"


@dataclass(frozen=True, repr=False)
class Campaign(Shown):
    """A header and the tests in the order in which they run; ``source`` is the text that they were read from.

    ``protocol`` is what ``[protocol]`` states, an object of the class of its ``protocol_kind``; None where steps are given.
    """

    header: Header
    tests: tuple[Test, ...]
    source: str = ""
    protocol: Any = None
    protocol_kind: str = ""

    @property
    def digest(self) -> str:
        """A hash of what is run, in its order; of a file that a step names what is in it counts, and not where it lies."""
        return _digest(
            (test.name, test.kind, repr(replace(test.step, **test.contents)), *test.additions) for test in self.tests
        )

    @property
    def path_digest(self) -> str:
        """The digest of before 2026-11-23: of a file that a step names its absolute path."""
        return _digest((test.name, test.kind, repr(test.step), *test.additions) for test in self.tests)

    @property
    def preliminary(self) -> QuasiStatic | None:
        """The slow stroke before the first test, or None."""
        amplitude = self.header.check_amplitude
        return QuasiStatic(amplitude, speed=0.005, cycles=1, rest_before=1.0) if amplitude else None


def _digest(contents: Iterable[tuple[str, ...]]) -> str:
    return hashlib.sha256(repr(list(contents)).encode()).hexdigest()[:16]


def read(path: str | Path, seed: int | None = None) -> Campaign:
    """The campaign in a TOML file; ``seed`` takes the place of the file's.

    Raises :class:`~dampyr.errors.FileError` that says what is wrong and where, and MissingData where a file is not there.
    """
    path = Path(path)
    document = load_toml(path)
    try:
        campaign = campaign_of(document, path.parent, seed)
    except (FileError, MissingData):
        raise
    except DampyrError as problem:
        raise FileError(path, str(problem)) from None
    header = campaign.header if campaign.header.name else replace(campaign.header, name=path.stem)
    return replace(campaign, source=path.read_text("utf-8"), header=header)


def campaign_of(
    document: Mapping[str, Any], folder: str | Path = ".", seed: int | None = None, max_tests: int = MAX_TESTS
) -> Campaign:
    """The campaign in a table as TOML gives it.

    Parameters
    ----------
    document
        The header's fields, and under "step" a list of tables with a kind and its fields, or under "protocol" a table with a
        kind of protocol and its numbers; quantities may be texts with a unit.
    folder
        Where the files that it names are looked for: ground motions, structures, tables of rows.
    seed
        Takes the place of the seed of the random order that the document states.
    max_tests
        The number of tests beyond which it is refused: they are counted before any is built.

    Returns
    -------
    Campaign
        The header and every test, in the order in which they run.

    Raises
    ------
    InputError
        A field is missing, not known or outside of its range, or there are too many tests.
    MissingData
        A file that it names is not there.

    Examples
    --------
    >>> import dampyr as dp
    >>> step = {"kind": "sine", "amplitude": "5 mm", "frequency": ["1 Hz", "2 Hz"]}
    >>> [test.name for test in dp.campaigns.campaign_of({"step": [step]}).tests]
    ['01-sine-5mm-1Hz-0V', '02-sine-5mm-2Hz-0V']
    """
    allowed = [*(field.name for field in fields(Header)), "protocol", "step"]
    for name in document:
        if name not in allowed:
            raise InputError(unknown(name, name, allowed))
    head = {name: value for name, value in document.items() if name not in ("protocol", "step")}
    header = fill(Header, head | ({} if seed is None else {"seed": seed}))
    step_tables = document.get("step")
    protocol, protocol_name = None, ""
    if "protocol" in document:
        if step_tables is not None:
            raise InputError(
                "a campaign has [protocol] or [[step]], not both; put the steps into a campaign of their own"
            )
        if header.order != "as written":
            raise InputError(
                'order = "random" is not allowed with a protocol, whose tests have an order; leave order out'
            )
        protocol, protocol_name, step_tables = _read_protocol(document["protocol"])
    if (
        not isinstance(step_tables, list)
        or not step_tables
        or not all(isinstance(table, Mapping) for table in step_tables)
    ):
        raise InputError("there is no step; give at least one table [[step]] with its kind")
    tables = [_read_step(table, k + 1, Path(folder), header.learn) for k, table in enumerate(step_tables)]
    _check_count(tables, max_tests)
    steps = [
        (table, _build_step(table.cls, row, table.where, Path(folder)))
        for table in tables
        for row in expanded(table.fields, table.cls, table.where, table.zipped, table.rows)
    ]
    tests = [test for k, (table, step) in enumerate(steps) for test in _repeat_test(k + 1, len(steps), table, step)]
    return Campaign(header, tuple(_order_tests(tests, header)), protocol=protocol, protocol_kind=protocol_name)


def _read_protocol(table: Any) -> tuple[Any, str, list[dict[str, Any]]]:
    """What a ``[protocol]`` states, its kind, and the ``[[step]]`` tables that it stands for."""
    if not isinstance(table, Mapping):
        raise InputError(f"protocol = {table!r} must be a table [protocol] with its kind")
    if "kind" not in table:
        raise InputError('protocol.kind is missing; give the kind of protocol, such as kind = "peak_velocity"')
    name = value_of(str, table["kind"], "protocol.kind")
    try:
        cls = protocol_kind(name)
    except InputError as problem:
        raise InputError(f"protocol.kind: {problem}") from None
    try:
        protocol = fill(cls, {field: value for field, value in table.items() if field != "kind"}, "protocol")
        return protocol, name, list(protocol.steps())
    except InputError as problem:
        text = str(problem)
        raise InputError(text if text.startswith("protocol") else f"protocol.{text}") from None


@dataclass(frozen=True)
class _StepTable:
    """A ``[[step]]`` before it becomes tests: its fields, and the rows of the table that it names."""

    where: str
    number: int
    kind: str
    cls: Any
    fields: Row
    zipped: bool
    rows: list[Row]
    repeats: int
    learn: bool

    @property
    def count(self) -> int:
        """Number of its tests."""
        return count_rows(self.fields, self.cls, self.zipped, self.rows)[0] * self.repeats


def _read_step(table: Mapping[str, Any], number: int, folder: Path, learn_all: bool) -> _StepTable:
    where = f"step {number}"
    if "kind" not in table:
        raise InputError(f'{where}.kind is missing; give the kind of step, such as kind = "sine"')
    kind = value_of(str, table["kind"], f"{where}.kind")
    try:
        cls = kind_of(kind)
    except InputError as problem:
        raise InputError(f"{where}.kind: {str(problem).replace('the steps', 'the kinds of step')}") from None
    repeats = value_of(int, table.get("repeats", 1), f"{where}.repeats")
    if repeats < 1:
        raise InputError(f"{where}.repeats = {repeats} is not allowed; it must be at least 1")
    step_fields = {name: value for name, value in table.items() if name not in TABLE_KEYS}
    rows = read_rows(folder / value_of(str, table["rows"], f"{where}.rows")) if "rows" in table else []
    zipped = value_of(bool, table.get("zip", False), f"{where}.zip")
    learn = _is_learned(table, where, kind, cls, learn_all)
    return _StepTable(where, number, kind, cls, step_fields, zipped, rows, repeats, learn)


def _is_learned(table: Mapping[str, Any], where: str, kind: str, cls: Any, learn_all: bool) -> bool:
    """Whether the drives of a step are learned."""
    can = bool(getattr(cls, "learns", False))
    learn = value_of(bool, table.get("learn", learn_all and can), f"{where}.learn")
    if learn and not can:
        raise InputError(
            f"{where}.learn = true is not allowed for the kind {kind}, whose table does not follow set points to their end; "
            f"the kinds that can learn are {', '.join(learning_steps())}; leave learn out"
        )
    return learn


def _check_count(steps: list[_StepTable], max_tests: int) -> None:
    """Refuse too many tests by their number, with the lists that they come from."""
    total = sum(step.count for step in steps)
    if total <= max_tests:
        return
    largest = max(steps, key=lambda step: step.count)
    number, factors = count_rows(largest.fields, largest.cls, largest.zipped, largest.rows)
    if largest.repeats > 1:
        factors, number = [*factors, f"{_readable_count(largest.repeats)} repeats"], number * largest.repeats
    grid = f" ({largest.where}: {' x '.join(factors)} = {_readable_count(number)})" if len(factors) > 1 else ""
    raise InputError(
        f"the campaign has {_readable_count(total)} tests{grid}; split it into several of at most "
        f"{_readable_count(max_tests)}, or give shorter lists"
    )


def _readable_count(count: int) -> str:
    """A number of tests for a person; a power of ten where it is too long to read."""
    return f"{count:,}" if count < 10**15 else "more than 10^15"


def _build_step(cls: Any, row: Row, where: str, folder: Path) -> Any:
    """The step of one row of fields; files that it names are looked for in ``folder``."""
    row = _halve_peak_to_peak(cls, row, where)
    try:
        step = fill(cls, row, where)
    except InputError as problem:
        text = str(problem)
        raise InputError(text if text.startswith(where) else f"{where}.{text}") from None
    return step.located_in(folder) if hasattr(step, "located_in") else step


def _halve_peak_to_peak(cls: Any, row: Row, where: str) -> Row:
    """``peak_to_peak`` is another way to say the amplitude, of every kind that has one."""
    if "peak_to_peak" not in row or "amplitude" not in {field.name for field in fields(cls)}:
        return row
    if "amplitude" in row:
        raise InputError(f"{where} has amplitude and peak_to_peak; give one of the two")
    whole = value_of(Annotated[float, Length], row["peak_to_peak"], f"{where}.peak_to_peak")
    return {name: value for name, value in row.items() if name != "peak_to_peak"} | {"amplitude": round_trip(whole / 2)}


def _repeat_test(number: int, count: int, table: _StepTable, step: Any) -> Iterator[Test]:
    """The test with that number of ``count``, once for each of its repeats."""
    digits = max(2, len(str(count)))
    tags = [re.sub(r"[^\w.+-]", "_", shown(step, name, "").replace("/", "p")) for name in step.named]
    name = "-".join([f"{number:0{digits}d}", table.kind, *(tag for tag in tags if tag)])
    for k in range(1, table.repeats + 1):
        repeat_name = f"{name}-r{k}" if table.repeats > 1 else name
        yield Test(number, table.number, table.kind, step, k, repeat_name, table.learn)


def _order_tests(tests: list[Test], header: Header) -> Iterator[Test]:
    """As written, or drawn by the seed between the tests that keep their place."""
    rng = np.random.default_rng(header.seed)
    for fixed, neighbours in groupby(tests, key=lambda test: bool(test.step.fixed)):
        group = list(neighbours)
        places = range(len(group)) if fixed or header.order == "as written" else rng.permutation(len(group))
        yield from (group[int(k)] for k in places)
