"""Dampers written for other tools, as one file that a browser saves."""

import io
import zipfile

import pytest

pytest.importorskip("fastapi")

from dampyr import registry
from dampyr.console.damper_files import export_kinds, zipped_export
from dampyr.errors import InputError
from dampyr.export import export
from dampyr.studies import raminelli_2020


def test_the_zip_holds_the_files_that_the_export_writes(tmp_path):
    damper = raminelli_2020.damper()
    archive = zipfile.ZipFile(io.BytesIO(zipped_export(damper, "matlab")))
    written = export(damper, "matlab", tmp_path)
    assert sorted(archive.namelist()) == sorted(path.name for path in written)
    for path in written:
        assert archive.read(path.name) == path.read_bytes()


def test_every_kind_has_a_title_and_another_one_is_refused():
    kinds = export_kinds()
    assert list(kinds) == registry.names("dampyr.export.kinds")
    assert all(kinds.values())
    with pytest.raises(InputError, match="choose from"):
        zipped_export(raminelli_2020.damper(), "fortran")
