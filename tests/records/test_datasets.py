"""Fetching and finding the published data: checked by sha256, missing data said in one line."""

import hashlib
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from dampyr.errors import FileError, InputError, MissingData
from dampyr.records import campaign_folder, campaign_rows, datasets, fetch, locate


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A stand-in for the published folder, and a table that fits it."""
    folder = tmp_path / "published"
    folder.mkdir()
    header, row = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz,sha256\n", "{},4.2,1,0,20,1,{}\n"
    text = header
    for name in ("one.mat", "two.mat"):
        (folder / name).write_bytes(name.encode() * 100)
        text += row.format(name, hashlib.sha256((folder / name).read_bytes()).hexdigest())
    rows = campaign_folder._rows(Path("table"), text + ",4.2,2,0,20,1,\n", None)
    monkeypatch.setattr(datasets, "campaign_rows", lambda: rows)
    return folder


@pytest.fixture
def server(source):
    """The stand-in behind a web server on this machine."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *args):
            pass

    http = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(source)))
    thread = threading.Thread(target=http.serve_forever, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{http.server_address[1]}/"
    http.shutdown()
    http.server_close()
    thread.join()


def test_the_address_is_the_published_commit():
    labcontrol = datasets.LABCONTROL
    assert labcontrol.base_url.endswith("/labcontrol-data/mr-damper/e42439f08b227bb08e9923ee2736bedf2f4fe59a/data/")
    assert "doi.org/10.5281/zenodo.4445334" in labcontrol.citation


def test_fetch_gets_every_file_and_the_table(server, source, tmp_path):
    seen = []
    folder = fetch("labcontrol", tmp_path / "here", base_url=server, progress=seen.append)
    assert seen == ["one.mat", "two.mat"]
    assert sorted(p.name for p in folder.iterdir()) == ["campaign.csv", "one.mat", "two.mat"]
    assert (folder / "two.mat").read_bytes() == (source / "two.mat").read_bytes()


def test_a_file_that_is_there_is_kept_and_a_wrong_one_replaced(source, tmp_path):
    requested = []

    def downloader(url, output_file, pooch):
        requested.append(url.rpartition("/")[2])
        Path(output_file).write_bytes((source / requested[-1]).read_bytes())

    fetch("labcontrol", tmp_path / "here", downloader=downloader)
    assert requested == ["one.mat", "two.mat"]
    (tmp_path / "here" / "one.mat").write_bytes(b"spoilt")
    fetch("labcontrol", tmp_path / "here", downloader=downloader)
    assert requested == ["one.mat", "two.mat", "one.mat"]


def test_a_local_folder_serves_the_same(source, tmp_path):
    folder = fetch("labcontrol", tmp_path / "here", base_url=str(source))
    assert (folder / "one.mat").read_bytes() == (source / "one.mat").read_bytes()
    (source / "one.mat").write_bytes(b"other")
    with pytest.raises(FileError, match="its sha256 is"):
        fetch("labcontrol", tmp_path / "there", base_url=str(source))
    with pytest.raises(MissingData, match="there is no such file; give a folder that holds the data set"):
        fetch("labcontrol", tmp_path / "there", base_url=str(tmp_path))


def test_no_network_is_one_line_with_the_way_out(server, source, tmp_path):
    def downloader(url, output_file, pooch):
        raise ConnectionError("no route\nto host")

    with pytest.raises(MissingData, match=r"one\.mat cannot be fetched \(no route to host\); .*10\.5281") as caught:
        fetch("labcontrol", tmp_path / "here", downloader=downloader)
    assert "\n" not in str(caught.value)
    (source / "two.mat").unlink()
    with pytest.raises(MissingData, match=r"two\.mat cannot be fetched \(404"):
        fetch("labcontrol", tmp_path / "here", base_url=server)
    assert not (tmp_path / "here" / "campaign.csv").exists()


def test_the_wrong_file_is_not_kept(source, tmp_path):
    def downloader(url, output_file, pooch):
        Path(output_file).write_bytes(b"<html>sorry</html>")

    with pytest.raises(FileError, match=r"one\.mat: not the published file came"):
        fetch("labcontrol", tmp_path / "here", downloader=downloader)
    assert not (tmp_path / "here" / "one.mat").exists()


def test_locate(tmp_path, monkeypatch):
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    with pytest.raises(MissingData, match=r"get it with `dampyr datasets fetch labcontrol` .* or set DAMPYR_DATA"):
        locate("labcontrol")
    folder = tmp_path / "labcontrol-mr-damper"
    folder.mkdir()
    (folder / "campaign.csv").write_text("x")
    assert locate("labcontrol") == folder
    assert locate("labcontrol", folder) == folder
    monkeypatch.delenv("DAMPYR_DATA")
    assert datasets.data_root() == Path("../shared/data")
    with pytest.raises(InputError, match=r"'zenodo' is no data set; choose from labcontrol"):
        locate("zenodo")


def test_the_packaged_table_names_39_files_with_checksums():
    named = [row for row in campaign_rows() if row.file_name]
    assert len(named) == 39
    assert all(len(row.sha256) == 64 for row in named)
    assert datasets.missing_files("no such folder") == [row.file_name for row in named]


def test_the_real_folder_is_complete(data_root):
    assert datasets.missing_files(locate("labcontrol", data_root)) == []
