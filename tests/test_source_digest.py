"""The version that files carry tells two codes of one version apart."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from packaging.version import Version

import dampyr as dp
from dampyr import source_digest
from dampyr.cli._frame import cli
from dampyr.source_digest import full_version


def test_the_version_is_followed_by_the_digest_of_the_sources() -> None:
    parsed = Version(full_version())
    assert parsed.public == dp.__version__
    assert re.fullmatch(r"[0-9a-f]{12}", full_version().split("+")[1])


def test_another_code_of_the_same_version_is_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    versions = []
    (tmp_path / "module.py").write_text("a = 1\n")
    monkeypatch.setattr(source_digest, "PACKAGE", tmp_path)
    try:
        for text in ("a = 1\n", "a = 2\n"):
            (tmp_path / "module.py").write_text(text)
            source_digest.source_digest.cache_clear()
            versions.append(full_version())
    finally:
        source_digest.source_digest.cache_clear()
    assert versions[0] != versions[1]


def test_the_command_line_prints_it() -> None:
    assert CliRunner().invoke(cli, ["--version"]).output == f"dampyr {full_version()}\n"


@pytest.mark.parametrize("kind", ["c", "fmu", "matlab", "opensees"])
def test_every_export_carries_it(kind: str, tmp_path: Path) -> None:
    damper = dp.studies.raminelli_2020.damper()
    options = {"inputs": [1.98]} if kind == "opensees" else {}
    dp.export.export(damper, kind, tmp_path, **options)
    texts = b"".join(file.read_bytes() for file in tmp_path.rglob("*") if file.is_file() and file.suffix != ".fmu")
    archives = b"".join(_unfolded(file) for file in tmp_path.rglob("*.fmu"))
    assert full_version().encode() in texts + archives


def _unfolded(archive: Path) -> bytes:
    import zipfile

    with zipfile.ZipFile(archive) as folder:
        return b"".join(folder.read(name) for name in folder.namelist() if not name.startswith("binaries"))


def test_a_card_and_a_page_carry_it(tmp_path: Path) -> None:
    damper = dp.studies.raminelli_2020.damper()
    assert full_version() in damper.save(tmp_path / "card.toml").read_text("utf-8")
    response = dp.structures.respond(
        dp.structures.two_storey(), dp.ground_motions.el_centro(), {1: damper}, voltage=1.98
    )
    page = dp.show.write_page(response, tmp_path / "page.html")
    assert full_version() in Path(page).read_text("utf-8")


def test_a_record_file_carries_it(tmp_path: Path) -> None:
    import h5py

    t = [0.1 * k for k in range(20)]
    path = dp.records.write(dp.records.Record(t, t, t), tmp_path / "record.h5")
    with h5py.File(path) as file:
        assert file.attrs["written_by"] == f"dampyr {full_version()}"
    assert dp.records.read(path).n == 20
