"""Open data sets: what each holds and is good for, its licence, where it is on this machine, and how to get it.

One TOML file of this folder is one set, called as the file::

    import dampyr as dp
    from dampyr.records import datasets

    print(datasets.data_set("labcontrol").licence)
    folder = dp.records.fetch("labcontrol")  # from the network; or from a local folder: base_url="FOLDER"

The keys of a file are the fields of `DataSet`; what is not known is left out, and every list then says "unknown". Files stand
in tables ``[[files]]`` (`DataFile`), or, where many lie in one place, in tables ``[[groups]]`` with ``prefix`` and ``names``.
"""

from __future__ import annotations

import csv
import hashlib
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import quote

from dampyr.atomic_write import whole_file
from dampyr.config import fill, load_toml
from dampyr.errors import FileError, InputError, MissingData, choose_from, one_line
from dampyr.records.files.folder_metadata import NAME as READING
from dampyr.records.files.folder_metadata import TABLE
from dampyr.source_file import SourceFile

__all__ = [
    "DataFile", "DataSet", "available_data_sets", "data_root", "data_set", "describe", "fetch", "locate", "missing_files",
    "data_set_of_file",
]  # fmt: skip

SUMS = "SHA256SUMS"
"""The file that remembers the sha256 of fetched files whose publishers give none; ``sha256sum -c`` reads it."""
NO_LICENCE = "none stated"


@dataclass(frozen=True)
class DataFile:
    """One file of a data set.

    ``name`` is what it is called here, ``path`` where it lies below the set's address (the name, where that is left out; "-":
    not known), ``sha256`` and ``size`` (bytes) what they are where they are known.
    """

    name: str
    path: str = ""
    sha256: str = ""
    size: int = 0

    @property
    def places(self) -> tuple[str, ...]:
        """Where it may lie in a folder: as the set's publisher has it, or beside the others."""
        published = () if self.path in ("", "-") else (self.path, Path(self.path).name)
        return tuple(dict.fromkeys((self.name, *published)))


@dataclass(frozen=True)
class FileGroup:
    """Files that lie in one place, ``prefix``, and whose sha256 nobody gives."""

    names: tuple[str, ...]
    prefix: str = ""


@dataclass(frozen=True)
class DataSet:
    """An open data set.

    ``kind`` is what was measured, in two words; ``page`` the address of a page for people, ``base_url`` the one that files lie
    below ("": dampyr does not fetch them), ``table`` the packaged table that names them and their sha256; ``licence`` is ""
    where none is stated, and ``licence_from`` says where that was read; ``version`` is that of the files, such as the commit of
    their repository. ``reading`` is the ``reading.toml`` that is written
    beside the files, so that they are read without a word; ``folder`` the name of its folder below `data_root`.
    """

    name: str
    title: str
    kind: str
    page: str
    citation: str
    licence_from: str
    format: str
    specimen: str
    holds: str
    good_for: str
    folder: str
    licence: str = ""
    doi: str = ""
    version: str = ""
    base_url: str = ""
    size: int = 0
    count: int = 0
    table: str = ""
    reading: str = ""
    notes: tuple[str, ...] = ()
    files: tuple[DataFile, ...] = ()
    groups: tuple[FileGroup, ...] = ()

    @property
    def contents(self) -> tuple[DataFile, ...]:
        """Its files, as far as dampyr knows them."""
        if self.table:
            return tuple(DataFile(row["file"], sha256=row["sha256"]) for row in _table_rows(self.table) if row["file"])
        grouped = (DataFile(name, group.prefix + name) for group in self.groups for name in group.names)
        return (*self.files, *grouped)

    @property
    def licence_in_words(self) -> str:
        """The licence, or that none is stated."""
        return self.licence or NO_LICENCE

    @property
    def holds_records(self) -> bool:
        """Whether it is of tests of a damper."""
        return self.kind.endswith("damper")


@lru_cache(maxsize=1)
def _sets() -> Mapping[str, DataSet]:
    sets = {}
    for path in sorted(Path(__file__).parent.glob("*.toml")):
        table = load_toml(path)
        texts = {
            key: " ".join(text.split()) for key, text in table.items() if isinstance(text, str) and key != "reading"
        }
        sets[path.stem] = fill(DataSet, table | texts | {"name": path.stem}, path.name)
    return sets


def available_data_sets() -> list[str]:
    """The names of all data sets, those of MR dampers first."""
    return sorted(_sets(), key=lambda name: (_sets()[name].kind != "MR damper", name))


def data_set(name: str) -> DataSet:
    """The data set called ``name``, or an :class:`InputError` that lists what there is."""
    if name in _sets():
        return _sets()[name]
    raise InputError(f"{name!r} is not a data set; {choose_from(name, available_data_sets())}")


def _table_rows(table: str) -> list[dict[str, str]]:
    text = resources.files("dampyr.records").joinpath(table).read_text("utf-8")
    return list(csv.DictReader(text.splitlines()))


@lru_cache(maxsize=1)
def _set_by_sha256() -> Mapping[str, DataSet]:
    return {file.sha256: dataset for dataset in _sets().values() for file in dataset.contents if file.sha256}


def data_set_of_file(file: SourceFile, folder: Path | None = None) -> DataSet | None:
    """The data set of which ``file`` is a file, by its SHA-256, whatever it is called; None where dampyr knows none.

    Of a set whose publisher gives no SHA-256, the files that were fetched into ``folder`` are known by the sums beside them.
    """
    known = _set_by_sha256().get(file.sha256)
    if known is not None or folder is None or (sums := _read_sums(folder)).get(file.name) != file.sha256:
        return known
    return next(
        (each for each in _sets().values() if set(sums) <= {f.name for f in each.contents if not f.sha256}), None
    )


def data_root() -> Path:
    """Where data sets lie: the environment variable DAMPYR_DATA, else ``../shared/data`` from here."""
    return Path(os.environ.get("DAMPYR_DATA") or Path("..") / "shared" / "data")


def locate(name: str = "labcontrol", root: str | Path | None = None) -> Path:
    """The folder of a data set on this machine.

    Raises
    ------
    MissingData
        It is not there; the message says how to get it.
    """
    dataset = data_set(name)
    base = data_root() if root is None else Path(root)
    signs = [TABLE] if dataset.table else [file.name for file in dataset.contents]
    for folder in (base / dataset.folder, base):
        if any((folder / sign).is_file() for sign in signs):
            return folder
    raise MissingData(
        f"the data set {name} is not in {base}; get it with `dampyr datasets fetch {name}` "
        f"({_source_in_words(dataset)}), or set DAMPYR_DATA to the folder that holds {dataset.folder}"
    )


def missing_files(folder: str | Path, name: str = "labcontrol") -> list[str]:
    """The files of a data set that ``folder`` does not hold."""
    return [file.name for file in data_set(name).contents if not (Path(folder) / file.name).is_file()]


def describe(name: str) -> dict[str, Any]:
    """All that is known of a data set, and its ``state`` on this machine: its ``folder`` (None: absent), what is missing."""
    dataset = data_set(name)
    try:
        folder = locate(name)
    except MissingData:
        folder = None
    missing = [] if folder is None else missing_files(folder, name)
    state = f"{len(missing)} files missing" if missing else "complete"
    left_out = ("contents", "files", "groups", "table", "reading")
    fields_of = {key: value for key, value in vars(dataset).items() if key not in left_out}
    fields_of |= {"licence": dataset.licence_in_words, "files": [asdict(file) for file in dataset.contents]}
    fields_of |= {"size": dataset.size or None, "count": dataset.count or None}
    return fields_of | {
        "state": f"absent; dampyr datasets fetch {name}" if folder is None else state,
        "folder": folder,
        "missing_files": None if folder is None else missing,
    }


def fetch(
    name: str = "labcontrol",
    folder: str | Path | None = None,
    base_url: str | None = None,
    downloader: Callable[..., Any] | None = None,
    progress: Callable[[str], None] | None = None,
    accept_no_licence: bool = False,
) -> Path:
    """Get a data set file by file, each checked against its sha256, and return its folder.

    A file whose sha256 nobody gives is recorded with the one of the first fetch, in ``SHA256SUMS`` beside it, and checked
    against that from then on.

    Parameters
    ----------
    name, folder
        Which one, and where to: by default its place below :func:`data_root`. Files that are there and right
        are kept.
    base_url, downloader
        Another source of the same files: an address that ends in "/" (or a local folder), a downloader as
        pooch takes it.
    progress
        Called with the name of each file when it is there.
    accept_no_licence
        Download a set that states no licence. Without one its files may be used only as the law, or their owner, allows.

    Raises
    ------
    MissingData
        The source cannot be reached, or dampyr does not know it; what did arrive stays and is not fetched again.
    FileError
        A file came that is not the one that was published: the message names it, the sha256 expected and the one that came.
    InputError
        The set states no licence and a download was not asked for by ``accept_no_licence``.
    """
    dataset = data_set(name)
    target = Path(folder) if folder is not None else data_root() / dataset.folder
    source = dataset.base_url if base_url is None else base_url
    _check_source(dataset, source, target, accept_no_licence)
    _make_folder(target)
    sums = _read_sums(target)
    for file in dataset.contents:
        sha256 = _get(dataset, file, file.sha256 or sums.get(file.name, ""), source, target, downloader)
        if not file.sha256 and file.name not in sums:
            sums[file.name] = sha256
            _write_sums(target, sums)
        if progress is not None:
            progress(file.name)
    if dataset.table:
        (target / TABLE).write_bytes(resources.files("dampyr.records").joinpath(dataset.table).read_bytes())
    if dataset.reading and not (target / READING).exists():  # the user's own goes before ours
        (target / READING).write_text(dataset.reading.lstrip(), encoding="utf-8")
    return target


def _check_source(dataset: DataSet, source: str, target: Path, accept_no_licence: bool) -> None:
    if not dataset.contents:
        raise MissingData(
            f"dampyr does not know the files of {dataset.name} one by one; get them from {_source_in_words(dataset)}, put them "
            f"in a folder such as {target} and name that folder"
        )
    if not source:
        raise MissingData(
            f"dampyr does not fetch {dataset.name} itself; get it from {_source_in_words(dataset)}, then "
            f"`dampyr datasets fetch {dataset.name} --from FOLDER`"
        )
    if "://" in source and not dataset.licence and not accept_no_licence:
        raise InputError(
            f"{dataset.name} states no licence ({dataset.licence_from}): its files may be used only as the law or their owner "
            "allows; to download them all the same give --accept-no-licence (accept_no_licence=True)"
        )


def _source_in_words(dataset: DataSet) -> str:
    return f"doi {dataset.doi}, {dataset.page}" if dataset.doi else dataset.page


def _make_folder(target: Path) -> None:
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise FileError(
            target, f"cannot be made ({problem.strerror}); choose a folder that can be written"
        ) from problem


def _get(dataset: DataSet, file: DataFile, sha256: str, source: str, target: Path, downloader: Any) -> str:
    """Put a file in its place, checked where its sha256 is known; its sha256."""
    if "://" in source:
        _download(dataset, file, sha256, source, target, downloader)
        return _sha256(target / file.name)
    candidates = [Path(source) / place for place in file.places if (Path(source) / place).is_file()]
    local = next((path for path in candidates if _sha256(path) == sha256), candidates[0] if candidates else None)
    if local is None:
        raise MissingData(
            f"{Path(source) / file.name}: there is no such file; give a folder that holds the data set {dataset.name}"
        )
    actual = _sha256(local)
    if sha256 and actual != sha256:
        whose = "the published file" if file.sha256 else f"the file of the first fetch, which {SUMS} remembers"
        raise FileError(
            local,
            f"its sha256 is {actual}, expected {sha256}: it is not {whose}; fetch it again, or from its publisher",
        )
    _copy(local, target / file.name)
    return actual


def _download(dataset: DataSet, file: DataFile, sha256: str, source: str, target: Path, downloader: Any) -> None:
    import pooch

    if file.path == "-":
        raise MissingData(
            f"where {file.name} lies below {source} is not known; get {dataset.name} from {_source_in_words(dataset)}, then "
            f"`dampyr datasets fetch {dataset.name} --from FOLDER`"
        )
    address = source + quote(file.path or file.name)
    logger = pooch.get_logger()
    level = logger.level
    logger.setLevel("WARNING")
    pooch_hash = f"sha256:{sha256}" if sha256 else None
    try:
        pooch.retrieve(url=address, known_hash=pooch_hash, fname=file.name, path=target, downloader=downloader)
    except Exception as problem:  # whatever the network throws
        if "does not match" in str(problem):
            got = str(problem).partition(" but got ")[2][:64]
            message = f"not the published file came: its sha256 is {got}, expected {sha256}; fetch again"
            raise FileError(target / file.name, message) from problem
        reason = one_line(problem)
        reason = reason if len(reason) <= 160 else reason[:157] + "..."
        raise MissingData(
            f"{address} cannot be fetched ({reason}); check the network, or get it from "
            f"{f'https://doi.org/{dataset.doi}' if dataset.doi else dataset.page} and put it in {target}, or "
            "give a folder that holds the set (--from)"
        ) from problem
    finally:
        logger.setLevel(level)


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read_sums(target: Path) -> dict[str, str]:
    path = target / SUMS
    lines = path.read_text("utf-8").splitlines() if path.is_file() else []
    return {name: sha256 for sha256, _, name in (line.partition("  ") for line in lines) if name}


def _write_sums(target: Path, sums: Mapping[str, str]) -> None:
    text = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(sums.items()))
    with whole_file(target / SUMS) as new:
        new.write_text(text, encoding="utf-8")


def _copy(source: Path, target: Path) -> None:
    if target.exists() and target.samefile(source):
        return
    part = target.with_name(target.name + ".part")
    part.write_bytes(source.read_bytes())
    part.replace(target)
