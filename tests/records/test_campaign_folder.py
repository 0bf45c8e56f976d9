"""A campaign folder: the table's order, roles, labels and checksums; recorded folders with tries."""

import hashlib
import shutil

import numpy as np
import pytest
from scipy.io import savemat

from dampyr import registry
from dampyr.errors import FileError, InputError, MissingData
from dampyr.records import read_campaign, write
from dampyr.records.files.campaign_folder import campaign_rows, read_row
from dampyr.records.record import Label

HEADER = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz,kx_Ns_per_mm,kw_N,rho_per_mm,sha256"


@pytest.fixture
def small(tmp_path):
    t = 0.01 * np.arange(60)
    rows = [HEADER]
    for k, (table, row) in enumerate([("4.3", "2"), ("4.3", "1"), ("fig 1", "")]):
        x = 10 * np.sin(6 * t + k)
        values = {"Ts": 0.01, "dist": x, "forc": 100 + x, "x_F": np.column_stack([x, x, x])}
        savemat(tmp_path / f"t{k}.mat", values, oned_as="column")
        sha = hashlib.sha256((tmp_path / f"t{k}.mat").read_bytes()).hexdigest()
        rows.append(f"t{k}.mat,{table},{row},0.8712,20.5,0.95,1.5,200.25,19.5,{sha}")
    rows.insert(3, ",4.3,3,0.8712,18,1.0,1.5,200,19.5,")
    rows.insert(4, "gone.mat,4.3,4,0.8712,18,1.0,1.5,200,19.5,abc")
    (tmp_path / "campaign.csv").write_text("\n".join(rows) + "\n")
    return tmp_path


def test_fit_records_in_the_order_of_the_table(small):
    records = read_campaign(small)
    assert [record.name for record in records] == ["t0", "t1"]
    assert {record.role for record in records} == {"fit"}
    assert records[0].voltage == 0.8712
    assert records[0].label == Label(0.0205, 0.95, "4.3", 2)
    assert len(records[0].provenance["sha256"]) == 64


def test_validation_only_when_asked(small):
    assert [(r.name, r.role) for r in read_campaign(small, role="validation")] == [("t2", "validation")]
    assert [r.name for r in read_campaign(small, role=None)] == ["t0", "t1", "t2"]
    with pytest.raises(InputError, match="role = 'test' is not known"):
        read_campaign(small, role="test")


def test_rows_without_a_file_are_reported(small):
    rows = campaign_rows(small)
    assert [row.file_name for row in rows if row.file is None] == ["", "gone.mat"]
    assert [row.row for row in rows] == [2, 1, 3, 4, None]
    assert rows[0].published == {"kx": 1500.0, "kw": 200.25, "rho": 19500.0}
    with pytest.raises(MissingData, match=r"row 3 of table 4.3 has no file; choose another row"):
        read_row(rows[2])


def test_another_file_than_the_table_says(small):
    shutil.copy(small / "t0.mat", small / "t1.mat")
    with pytest.raises(FileError, match=r"t1\.mat: its sha256 is \w{64}, the table says \w{64}; fetch"):
        read_campaign(small)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("voltage_V", "volts", r"campaign\.csv: the column voltage_V is missing"),
        (
            "20.5",
            "wide",
            r"campaign\.csv: line 2: peak_to_peak_mm = 'wide' is not a number; repair the table",
        ),
        ("20.5", "-1", r"campaign\.csv: line 2: label peak_to_peak_m = -0.001 is not allowed"),
    ],
)
def test_a_broken_table(small, old, new, message):
    table = small / "campaign.csv"
    table.write_text(table.read_text().replace(old, new))
    with pytest.raises(FileError, match=message):
        read_campaign(small)


def test_no_folder_and_an_empty_folder(tmp_path):
    with pytest.raises(
        MissingData, match=r"there is no such folder; check the path, or fetch .*`dampyr datasets fetch"
    ):
        read_campaign(tmp_path / "no")
    suffixes = ", ".join(rf"\.{name}" for name in registry.names("dampyr.records.formats"))
    with pytest.raises(MissingData, match=f"the folder has no records; give a folder with {suffixes} files"):
        read_campaign(tmp_path)
    with pytest.raises(MissingData, match=r"there is no such table"):
        campaign_rows(tmp_path)


def test_a_recorded_folder_gives_the_latest_complete_try_of_each_test(tmp_path, make_sine):
    def put(file, name, test, attempt, complete="yes", role="fit"):
        provenance = {"test": test, "try": str(attempt), "complete": complete}
        write(make_sine(duration=3.0, rest=0.5, name=name, role=role, provenance=provenance), tmp_path / file)

    put("01-try1.h5", "a1", "a", 1)
    put("01-try10.h5", "a10", "a", 10)
    put("01-try2.h5", "a2", "a", 2)
    put("02-try1.h5", "b1", "b", 1)
    put("02-try2.h5", "b2", "b", 2, complete="no")
    put("03-try1.h5", "c1", "c", 1, role="validation")
    assert [record.name for record in read_campaign(tmp_path)] == ["a10", "b1"]
    assert [record.name for record in read_campaign(tmp_path, role="validation")] == ["c1"]
    every = [record.name for record in read_campaign(tmp_path, incomplete=True)]
    assert sorted(every) == ["a1", "a10", "a2", "b1", "b2"]


def test_the_packaged_table_is_the_real_one(campaign_folder):
    assert [row.label for row in campaign_rows()] == [row.label for row in campaign_rows(campaign_folder)]
    assert [row.sha256 for row in campaign_rows()] == [row.sha256 for row in campaign_rows(campaign_folder)]
    assert all(row.file is None for row in campaign_rows())


def test_the_real_campaign_has_38_fit_records_and_one_validation(campaign_folder):
    records = read_campaign(campaign_folder)
    voltages = [record.voltage for record in records]
    assert [voltages.count(v) for v in (0.0, 0.8712, 1.98, 3.212)] == [10, 10, 8, 10]
    assert [record.name for record in read_campaign(campaign_folder, role="validation")] == ["ensaio.vali.1"]
    missing = [(row.table, row.row) for row in campaign_rows(campaign_folder) if row.file is None]
    assert missing == [("4.4", 2), ("4.4", 4)]
    assert all(record.role == "fit" for record in records)
