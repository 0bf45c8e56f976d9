"""Messages on pages name no option of a command and no argument of Python."""

import re

import numpy as np
import pytest

pytest.importorskip("fastapi")

from dampyr import records
from dampyr.console.page_words import in_page_words
from dampyr.errors import DampyrError
from dampyr.studies import raminelli_2020

TEXTS = {
    "a,b,c\n": {}, "time [s],x,force [N]\n": {}, "time [s],x [mm],x [mm],force [N]\n": {"columns": {"displacement": "x"}},
    "time [s],x [mm],force [N],load [N]\n": {}, "time [s],x [mm],force [N]\n": {"dt": 0.1},
    "time [s],x [mm],force [N],voltage [V],current [A]\n": {}, "x [mm],force [N]\n": {}, "a,b,c,d,e,f,g\n": {},
}  # fmt: skip


@pytest.mark.parametrize("header", TEXTS)
def test_what_is_wrong_with_a_file_is_said_without_options(tmp_path, header):
    path = tmp_path / "a.csv"
    width = 5 if "current" in header else min(header.count(",") + 1, 4)
    rows = "".join(",".join(f"{k + 0.1 * j + np.sin(k):.3f}" for j in range(width)) + "\n" for k in range(20))
    path.write_text(header + rows)
    with pytest.raises(DampyrError) as raised:
        records.read(path, **TEXTS[header])
    words = in_page_words(str(raised.value))
    assert not re.search(r" --[a-z]|[a-z]=[A-Z{\d']", words), words


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("runs/a is used by another; wait, or give another --out", "runs/a is used by another; wait, or choose another folder"),
        ("no unit is known; declare it, such as units='g' or units='m/s^2'", "no unit is known; write it in the header"),
        ("no unit is known; declare it, such as --motion-unit g, units='g' or units='m/s^2'",
         "no unit is known; write it in the header"),
        ("give the seconds between samples, such as --dt 0.02 or dt=0.02",
         "give the seconds between samples in the first column"),
        ("a moving average shows: declare it, --smoothed '5 samples'",
         'a moving average shows: declare it in reading.toml: smoothed = "5 samples"'),
        ("leave it as it is", "leave it as it is"),
    ],
)  # fmt: skip
def test_messages_say_where_it_is_entered_on_a_page(said, words):
    assert in_page_words(said) == words


def test_an_input_beyond_the_range_says_what_to_tick():
    with pytest.raises(DampyrError) as raised:
        raminelli_2020.damper().force(np.arange(9.0), np.arange(9.0) * 1e-3, voltage=9.0)
    assert in_page_words(str(raised.value)).endswith("or allow extrapolation")
