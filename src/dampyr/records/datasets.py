"""Published data sets: where they are on this machine, and how to get them.

``labcontrol``: Labcontrol, UTFPR, A. N. Vargas, "Data, source code, and documents for the shaking table with
MR-damper", v1.0.3, 2021, doi 10.5281/zenodo.4445334; MIT licence, copyright (c) 2021 Labcontrol.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from dampyr.errors import FileError, InputError, MissingData
from dampyr.records.campaign_folder import TABLE, campaign_rows, check_sha256


@dataclass(frozen=True)
class DataSet:
    """A published data set: where its files come from, and how to cite it."""

    name: str
    folder: str
    base_url: str
    doi: str
    citation: str
    licence: str


LABCONTROL = DataSet(
    name="labcontrol",
    folder="labcontrol-mr-damper",
    base_url=(
        "https://raw.githubusercontent.com/labcontrol-data/mr-damper/e42439f08b227bb08e9923ee2736bedf2f4fe59a/data/"
    ),
    doi="10.5281/zenodo.4445334",
    citation=(
        "Labcontrol (UTFPR), A. N. Vargas: Data, source code, and documents for the shaking table with "
        "MR-damper, v1.0.3, 2021, https://doi.org/10.5281/zenodo.4445334"
    ),
    licence="MIT, copyright (c) 2021 Labcontrol",
)
DATA_SETS = (LABCONTROL,)


def data_set(name: str) -> DataSet:
    """The data set called ``name``, or an :class:`InputError` that lists what there is."""
    for dataset in DATA_SETS:
        if dataset.name == name:
            return dataset
    raise InputError(f"{name!r} is no data set; choose from {', '.join(dataset.name for dataset in DATA_SETS)}")


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
    for folder in (base / dataset.folder, base):
        if (folder / TABLE).is_file():
            return folder
    raise MissingData(
        f"the data set {name} is not in {base}; get it with `dampyr datasets fetch {name}` "
        f"(doi {dataset.doi}), or set DAMPYR_DATA to the folder that holds {dataset.folder}"
    )


def missing_files(folder: str | Path) -> list[str]:
    """The files that the packaged table lists and ``folder`` does not hold."""
    names = [row.file_name for row in campaign_rows() if row.file_name]
    return [name for name in names if not (Path(folder) / name).is_file()]


def fetch(
    name: str = "labcontrol",
    folder: str | Path | None = None,
    base_url: str | None = None,
    downloader: Callable[..., Any] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Path:
    """Get a data set file by file, each checked against its sha256, and return its folder.

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

    Raises
    ------
    MissingData
        The source cannot be reached; what did arrive stays and is not fetched again.
    FileError
        A file came that is not the one that was published.
    """
    dataset = data_set(name)
    target = Path(folder) if folder is not None else data_root() / dataset.folder
    source = dataset.base_url if base_url is None else base_url
    _make(target)
    for row in campaign_rows():
        if not row.file_name:
            continue
        _get(dataset, row.file_name, row.sha256, source, target, downloader)
        if progress is not None:
            progress(row.file_name)
    table = resources.files("dampyr.records").joinpath("labcontrol_campaign.csv").read_bytes()
    (target / TABLE).write_bytes(table)
    return target


def _make(target: Path) -> None:
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise FileError(
            target, f"cannot be made ({problem.strerror}); choose a folder that can be written"
        ) from problem


def _get(dataset: DataSet, file: str, sha256: str, source: str, target: Path, downloader: Any) -> None:
    local = Path(source) / file
    if "://" not in source and local.is_file():
        check_sha256(local, sha256)
        _copy(local, target / file)
        return
    if "://" not in source:
        raise MissingData(f"{local}: there is no such file; give a folder that holds the data set {dataset.name}")
    import pooch

    logger = pooch.get_logger()
    level = logger.level
    logger.setLevel("WARNING")
    try:
        pooch.retrieve(url=source + file, known_hash=f"sha256:{sha256}", fname=file, path=target, downloader=downloader)
    except Exception as problem:  # whatever the network throws
        if "does not match" in str(problem):
            raise FileError(
                target / file, f"not the published file came ({_reason(problem)}); fetch again"
            ) from problem
        raise MissingData(
            f"{source}{file} cannot be fetched ({_reason(problem)}); check the network, or get it from "
            f"https://doi.org/{dataset.doi} and put it in {target}"
        ) from problem
    finally:
        logger.setLevel(level)


def _copy(source: Path, target: Path) -> None:
    if target.exists() and target.samefile(source):
        return
    part = target.with_name(target.name + ".part")
    part.write_bytes(source.read_bytes())
    part.replace(target)


def _reason(problem: BaseException) -> str:
    text = " ".join(str(problem).split()) or type(problem).__name__
    return text if len(text) <= 160 else text[:157] + "..."
