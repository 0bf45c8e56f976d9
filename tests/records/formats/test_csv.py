"""Records as text with units in the header: every bit, and an input that varies."""

import numpy as np
import pandas

from dampyr.origin import PublishedData
from dampyr.records import read, write


def test_a_csv_keeps_every_bit_and_a_varying_input(tmp_path, make_sine):
    record = make_sine()
    record = record.replace(note="a varying input", current=np.linspace(0.1, 0.7, record.n), voltage=None)
    back = read(write(record, tmp_path / "a.csv"))
    assert np.array_equal(back.force, record.force)
    assert np.array_equal(back.current, record.current)


def test_numbers_have_the_fewest_digits_that_give_them_back(tmp_path, make_sine):
    record = make_sine(voltage=1.98)
    record = record.replace(note="", force=np.nextafter(record.force, 1e9), displacement=record.displacement / 3)
    lines = write(record, tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == "time [s],displacement [m],force [N],voltage [V]"
    assert lines[2].split(",")[0::3] == ["0.01", "1.98"]
    frame = pandas.read_csv(tmp_path / "a.csv")
    assert np.array_equal(frame["force [N]"], record.force)
    assert np.array_equal(frame["displacement [m]"], record.displacement)


def test_the_published_data_set_goes_with_the_columns(tmp_path, make_sine):
    published = {
        "data_set": "labcontrol",
        "data_set_version": "commit e42439f",
        "doi": "10.5281/zenodo.1",
        "licence": "MIT",
    }
    record = make_sine(provenance=published)
    for suffix in ("csv", "nc", "h5"):
        back = read(write(record, tmp_path / f"a.{suffix}"))
        assert back.origin.data_sets == (PublishedData("labcontrol", "10.5281/zenodo.1", "MIT", "commit e42439f"),)
    assert (tmp_path / "a.csv").read_text().startswith("# data_set: labcontrol\n# data_set_version: commit e42439f\n")
