"""Fetching and finding the published data: checked by sha256, missing data said in one line."""

import csv
import hashlib
import re
import shutil
import threading
import warnings
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import dampyr as dp
from dampyr.config import parse_toml
from dampyr.errors import DampyrWarning, FileError, InputError, MissingData
from dampyr.records import datasets, fetch, locate
from dampyr.records.files.campaign_folder import campaign_rows


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
    rows = list(csv.DictReader((text + ",4.2,2,0,20,1,\n").splitlines()))
    monkeypatch.setattr(datasets, "_table_rows", lambda table: rows)
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
    labcontrol = datasets.data_set("labcontrol")
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
    wrong, right = (hashlib.sha256(text).hexdigest() for text in (b"other", b"one.mat" * 100))
    with pytest.raises(
        FileError, match=rf"published/one\.mat: its sha256 is {wrong}, expected {right}: it is not the pub"
    ):
        fetch("labcontrol", tmp_path / "there", base_url=str(source))
    assert not (tmp_path / "there" / "one.mat").exists()
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

    came = hashlib.sha256(b"<html>sorry</html>").hexdigest()
    wanted = hashlib.sha256((source / "one.mat").read_bytes()).hexdigest()
    with pytest.raises(
        FileError, match=rf"one\.mat: not the published file came: its sha256 is {came}, expected {wanted}"
    ):
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
    with pytest.raises(InputError, match=r"'zenodo' is not a data set; choose from labcontrol"):
        locate("zenodo")


def test_the_packaged_table_names_39_files_with_checksums():
    named = [row for row in campaign_rows() if row.file_name]
    assert len(named) == 39
    assert all(len(row.sha256) == 64 for row in named)
    assert datasets.missing_files("no such folder") == [row.file_name for row in named]


def test_the_real_folder_is_complete(data_root):
    assert datasets.missing_files(locate("labcontrol", data_root)) == []


def test_six_sets_and_four_of_mr_dampers_are_listed():
    kinds = [datasets.data_set(name).kind for name in datasets.available_data_sets()]
    assert kinds.count("MR damper") >= 4
    assert len(kinds) >= 6


@pytest.mark.parametrize("name", datasets.available_data_sets())
def test_an_entry_says_only_what_fits_together(name):
    one = datasets.data_set(name)
    contents = one.contents
    assert len({file.name for file in contents}) == len(contents) == (one.count or len(contents))
    assert all(re.fullmatch("[0-9a-f]{64}|", file.sha256) for file in contents)
    assert one.page.startswith("https://")
    assert not one.base_url or (one.base_url.startswith("https://") and one.base_url.endswith("/"))
    assert not one.doi or re.fullmatch(r"10\.\d{4,}/\S+", one.doi)
    assert all((one.title, one.citation, one.licence_from, one.format, one.specimen, one.holds, one.good_for))
    sizes = [file.size for file in contents]
    assert not all(sizes) or not sizes or sum(sizes) == one.size
    if one.reading:
        assert parse_toml(one.reading)


@pytest.mark.parametrize("name", ["labcontrol", "labcontrol_motions", "el_centro_peknold", "vrths_2020"])
def test_a_local_folder_serves_the_sets_whose_checksums_are_in_dampyr(name, data_root, tmp_path):
    source = data_root / datasets.data_set(name).folder
    folder = fetch(name, tmp_path, base_url=str(source))
    assert datasets.missing_files(folder, name) == []
    assert all(file.sha256 for file in datasets.data_set(name).contents)
    assert not (folder / datasets.SUMS).exists()


def test_a_local_folder_may_have_the_publishers_names(data_root, tmp_path):
    published = tmp_path / "clone"
    published.mkdir()
    (published / "elcentro.dat").write_bytes((data_root / "ground-motions/el_centro_1940_ns_peknold.dat").read_bytes())
    folder = fetch("el_centro_peknold", tmp_path / "here", base_url=str(published))
    assert [path.name for path in folder.iterdir()] == ["el_centro_1940_ns_peknold.dat"]


def test_the_first_fetch_is_remembered_where_nobody_gives_a_checksum(tmp_path):
    source, here = tmp_path / "published", tmp_path / "here"
    source.mkdir()
    for name in ("ranran_50_converted.csv", "ransim_u_converted.csv"):
        (source / name).write_text(f"{name}\n" * 3)
    fetch("nees_2012_1158", here, base_url=str(source))
    lines = (here / "SHA256SUMS").read_text().splitlines()
    first = hashlib.sha256((source / "ranran_50_converted.csv").read_bytes()).hexdigest()
    assert lines[0] == f"{first}  ranran_50_converted.csv"
    assert len(lines) == 2
    fetch("nees_2012_1158", here, base_url=str(source))
    (source / "ranran_50_converted.csv").write_text("another")
    second = hashlib.sha256(b"another").hexdigest()
    with pytest.raises(
        FileError, match=rf"its sha256 is {second}, expected {first}: .* first fetch, which SHA256SUMS remem"
    ):
        fetch("nees_2012_1158", here, base_url=str(source))


def test_an_absent_licence_is_said_and_must_be_accepted(tmp_path):
    requested = []

    def downloader(url, output_file, pooch):
        requested.append(url)
        Path(output_file).write_bytes(b"x")

    with pytest.raises(InputError, match=r"ohtori_2004 states no licence .* give --accept-no-licence"):
        fetch("ohtori_2004", tmp_path, downloader=downloader)
    assert not requested
    folder = fetch("ohtori_2004", tmp_path, downloader=downloader, accept_no_licence=True)
    assert len(requested) == 8
    assert requested[0].endswith("Fuzzy-Cable-Building/200492769f132ddbdbbd027baeb409e0482ea9e1/struct20.m")
    assert len((folder / "SHA256SUMS").read_text().splitlines()) == 8


def test_a_set_that_is_not_fetched_says_where_it_is(tmp_path, data_root):
    with pytest.raises(
        MissingData, match=r"does not fetch sano_wang_2008 itself; get it from https://www.mathworks.* --from"
    ):
        fetch("sano_wang_2008", tmp_path)
    with pytest.raises(
        MissingData, match=r"does not know the files of brfd_2022 one by one; get them from https://github"
    ):
        fetch("brfd_2022", tmp_path)
    file = data_root / "ground-motions" / "ElCentroData.mat"
    with pytest.raises(MissingData, match=r"where elcentro\.dat lies .* is not known; .* --from FOLDER"):
        fetch("labcontrol_motions", tmp_path, downloader=lambda url, output_file, pooch: shutil.copy(file, output_file))


def write_sines(path, rows, header=None):
    """A file of a set, of a Dahl-like damper, as its publisher lays it out."""
    text = rows if isinstance(rows, str) else "\n".join("   ".join(f"{value:.7e}" for value in row) for row in rows)
    path.write_text(text if header is None else f"{header}\n{text}\n", encoding="utf-8")


def test_the_sines_of_quiroz_are_read_without_a_word(tmp_path):
    source = tmp_path / "published"
    source.mkdir()
    t = 0.001 * np.arange(3000)
    for file in datasets.data_set("quiroz_2022").contents:
        amplitude = float(file.name.partition("mm")[0])
        x, v = amplitude * np.sin(6 * t), 6 * amplitude * np.cos(6 * t)
        (source / file.path).parent.mkdir(parents=True, exist_ok=True)  # as in a clone of the repository
        write_sines(source / file.path, np.column_stack([t, x, v, 300 * np.tanh(v)]))
    folder = fetch("quiroz_2022", tmp_path / "here", base_url=str(source))
    records = dp.records.read_campaign(folder)
    assert len(records) == 30
    assert sorted({record.current for record in records}) == [0.0, 0.25, 0.5, 0.75, 1.0]
    [record] = [record for record in records if record.name == "10mm1Hz0x25A"]
    assert np.ptp(record.displacement) == pytest.approx(0.020, rel=1e-3)
    assert record.velocity.max() == pytest.approx(0.060, rel=1e-3)
    published = datasets.data_set("quiroz_2022")
    assert {str(each.origin.data_sets[0]) for each in records} == {f"quiroz_2022 ({published.licence})"}
    shutil.copy(folder / "10mm1Hz0x25A.txt", tmp_path)
    shutil.copy(folder / "reading.toml", tmp_path)
    assert not dp.records.read(tmp_path / "10mm1Hz0x25A.txt").origin.data_sets  # no fetch wrote it there


def test_the_random_tests_of_nees_are_read_without_a_word(tmp_path):
    source = tmp_path / "published"
    source.mkdir()
    t = 0.0003328 * np.arange(3000)
    x, v, u = 0.5 * np.sin(20 * t), 10 * np.cos(20 * t), 1.0 + np.sin(3 * t)
    lines = [
        f"{a:.7g},-1.2,{b:.6g},{d:.5g},{'3004.8' if k == 0 else ''},{c:.6g},{900 * np.tanh(c):.6g},"
        for k, (a, b, c, d) in enumerate(zip(t, x, v, u, strict=True))
    ]
    for file in datasets.data_set("nees_2012_1158").contents:
        write_sines(source / file.name, "\n".join(lines), '"t","A","D","Y","fs","V","F",')
    folder = fetch("nees_2012_1158", tmp_path / "here", base_url=str(source))
    [record, _] = dp.records.read_campaign(folder)
    assert np.ptp(record.displacement) == pytest.approx(0.010, rel=1e-2)
    assert record.force.max() == pytest.approx(900.0, rel=1e-3)
    assert np.ptp(record.voltage) == pytest.approx(
        1.0 + np.sin(3 * t[-1]) - 1.0 if t[-1] < 0.5 else np.ptp(u), rel=1e-2
    )


def test_the_test_of_sano_and_wang_is_read_without_a_word(tmp_path):
    source = tmp_path / "data"
    source.mkdir()
    v = 5 * np.cos(9 * 0.005 * np.arange(3499))
    savemat(source / "mrdamper.mat", {"F": 60 * np.tanh(v)[:, None], "V": v[:, None], "Ts": 0.005})
    folder = fetch("sano_wang_2008", tmp_path / "here", base_url=str(source))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the displacement is integrated, and says so
        [record] = dp.records.read_campaign(folder)
    assert record.voltage == 1.25
    assert record.n == 3499
    assert record.velocity.max() == pytest.approx(0.05, rel=1e-2)
