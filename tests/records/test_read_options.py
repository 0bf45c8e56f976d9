"""What is said of a file when it is read: as an object or by name, and what is no option."""

import pytest

from dampyr.errors import InputError
from dampyr.records import ReadOptions, read, write


@pytest.mark.parametrize("argument", ["units", "columns"])
def test_a_word_that_is_no_channel(tmp_path, argument):
    (tmp_path / "a.csv").write_text("t [s],x [m],f [N]\n0,0,0\n")
    with pytest.raises(InputError, match=rf"{argument} names 'stroke', which is not a channel; choose from time, "):
        read(tmp_path / "a.csv", **{argument: {"stroke": "mm"}})


def test_what_is_said_comes_as_one_object_or_by_name(tmp_path, make_sine):
    path = write(make_sine(), tmp_path / "a.csv")
    options = ReadOptions(voltage="1980 mV", specimen=" no. 7 ", smoothed=0.05, lowpass="40")
    assert (options.voltage, options.specimen, str(options.smoothed), options.lowpass) == (
        1.98,
        "no. 7",
        "0.05 s",
        40.0,
    )
    record = read(path, ReadOptions(voltage="1980 mV", specimen="no. 7"), voltage=0.5)
    assert (record.voltage, record.specimen) == (0.5, "no. 7")
    wrong = {
        "volt": (1.0, r"read\(..., volt=\) is not known; did you mean 'voltage'"),
        "dt": (-1.0, "dt = -1 s is not allowed; it must be greater than 0"),
        "header": (-1, "header = -1 is not allowed; it must be at least 0"),
        "variable": (" ", "variable = ' ' is not a name"),
        "columns": ({"force": 1.5}, r"columns\['force'\] = 1.5 must be a text or a whole number"),
        "specimen": ("", "specimen = '' is not a name"),
    }
    for name, (value, words) in wrong.items():
        with pytest.raises(InputError, match=words):
            read(path, **{name: value})
    with pytest.raises(
        InputError, match=r"read: options are of the type float; give ReadOptions, or keyword arguments"
    ):
        read(path, 1.98)
