"""Records as pages show them; read in a process with limits (:mod:`dampyr.console.workers`)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from dampyr import ground_motions, records
from dampyr.console import curves, record_sources
from dampyr.console.building_schemas import MOTION_SUFFIXES, MOTIONS
from dampyr.console.page_words import in_page_words
from dampyr.console.record_formats import FIGURE, NEED_VELOCITY
from dampyr.errors import DampyrError, FileError, InputError
from dampyr.records import Record
from dampyr.records.checks.quality import motion_start
from dampyr.records.cycle_analysis.amplitude_spectrum import repeated_spectrum
from dampyr.to_json import plain

MAX_MEASURED = 100_000  # samples, 100 s at 1 kHz: measuring them takes some 3 s


def describe_all(keys: list[str], data: Path) -> Iterator[dict[str, Any]]:
    """``about`` of the record of each key, what `dampyr records --json` prints of it, or the ``problem`` why it cannot be read;
    neither for a file that is not meant as a record.
    """
    for key in keys:
        try:
            if not record_sources.is_record(record_sources.place(data, key)):
                yield {}
                continue
            yield {"about": description(record_sources.read(data, key))}
        except DampyrError as problem:
            yield {"problem": (_another_kind(data, key) or str(problem))[:2000]}


def _another_kind(data: Path, key: str) -> str:
    """What a file that is not a record is, where that is known: a ground motion that does not lie in the folder of motions."""
    with suppress(DampyrError, OSError):
        path = record_sources.place(data, key)
        if path.suffix.lower() in MOTION_SUFFIXES:
            motion = ground_motions.read(path)
            return (
                f"a ground motion of {motion.duration:.4g} s and not a record of a damper; put it into the folder {MOTIONS} "
                "to choose it on the page Building"
            )
    return ""


def describe_one(data: Path, key: str) -> dict[str, Any]:
    """As `describe_all`, of one record that can be read."""
    return description(record_sources.read(data, key))


def description(record: Record) -> dict[str, Any]:
    """What `dampyr records --json` prints of a record; a very long one is measured on its first part, and says so."""
    if record.n <= MAX_MEASURED:
        return _with_notes(records.describe(record))
    first = record.until(float(record.time[MAX_MEASURED - 1]))
    shortened = f"measured on its first {first.duration:.4g} s of {record.duration:.4g} s: it has {record.n:,} samples"
    described = _with_notes(records.describe(first), shortened)
    described["history"] = list(record.history)
    described["duration_s"], described["quality"]["samples"] = record.duration, record.n
    return described


def curves_of(data: Path, key: str) -> dict[str, Any]:
    """The lines of one record, SI: over time, as loops, and by frequency; and when its motion begins."""
    record = _with_velocity(record_sources.read(data, key))
    assert record.velocity is not None
    begin = motion_start(record)
    if begin >= record.time[-1]:  # nothing moves
        begin = float(record.time[0])
    t, x, v, f = record.time - begin, record.displacement, record.velocity, record.force
    lines = {
        "displacement": curves.line(t, x, curves.ZOOMED),
        "velocity": curves.line(t, v, curves.ZOOMED),
        "force": curves.line(t, f, curves.ZOOMED),
        "force_displacement": curves.line(x, f, 2 * curves.POINTS),
        "force_velocity": curves.line(v, f, 2 * curves.POINTS),
    }
    spectrum = repeated_spectrum(record, "force")
    by_frequency = curves.line(spectrum.frequencies, spectrum.amplitudes).model_dump()
    return {
        "name": record.name,
        "begin": begin,
        **{name: line.model_dump() for name, line in lines.items()},
        "spectrum": plain(
            {**by_frequency, "of": spectrum.of, "excitation": spectrum.excitation, "harmonics": spectrum.harmonics()}
        ),
    }


def cycles_of(data: Path, key: str) -> list[Any]:
    """Every whole cycle of one record, SI."""
    return [plain(cycle) for cycle in records.cycle_table(record_sources.read(data, key))]


def export_record(data: Path, key: str, path: Path) -> str:
    """Write one record to ``path``, by whose suffix it is a format or a figure; its name."""
    record = record_sources.read(data, key)
    if path.suffix == f".{FIGURE}":
        from dampyr.show.figure_file import save
        from dampyr.show.figures.loops import loops

        shown = _with_velocity(record)
        drawn = loops(shown.displacement, shown.velocity, shown.force, title=record.name)
        save(record.origin.stamp(drawn), path)
    else:
        records.write(_with_velocity(record) if path.suffix in NEED_VELOCITY else record, path)
    return record.name


def _with_notes(described: dict[str, Any], *more: str) -> dict[str, Any]:
    """A description with its findings as the page's notes, after ``more``."""
    findings = described.pop("findings")
    return dict(plain(described)) | {"notes": [*more, *(in_page_words(finding["words"]) for finding in findings)]}


def take_upload(path: Path, to: Path, options: records.ReadOptions) -> dict[str, Any]:
    """Read the file ``path`` and write the file ``to`` (.h5)."""
    try:
        record = records.read(path, options)
        described = description(record)
        records.write(record, to)
    except FileError as problem:
        if problem.path == to:
            raise InputError(f"{path.name}: the record comes to more than may be written; cut it into parts") from None
        raise InputError(str(problem).replace(f"{path}", path.name)) from None
    return {"name": record.name, "history": list(record.history), "notes": described["notes"]}


def _with_velocity(record: Record) -> Record:
    return record if record.velocity is not None else records.with_velocity(record)
