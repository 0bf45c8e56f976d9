"""Cutting: every sample once, in pieces of a duration or between rests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import ReadOptions, Record, cut, read, read_campaign, write


def record(seconds: float = 23.0, dt: float = 0.01, **fields: object) -> Record:
    t = dt * np.arange(round(seconds / dt))
    return Record(t, 0.01 * np.sin(6 * t), np.cos(6 * t), name="long", **fields)  # type: ignore[arg-type]


def joined(pieces: list[Record], channel: str) -> np.ndarray:
    return np.concatenate([getattr(piece, channel) for piece in pieces])


@pytest.mark.parametrize(
    ("by", "lengths"), [(5.0, [500, 500, 500, 500, 300]), ("7 s", [700, 700, 900]), ("4s", [400] * 5 + [300])]
)
def test_pieces_of_a_duration_hold_every_sample_once(by: float | str, lengths: list[int]) -> None:
    whole = record(
        current=np.linspace(0.0, 1.0, 2300), specimen="no. 7", measurement_session="day 1", role="validation"
    )
    pieces = cut(whole, by)
    assert [piece.n for piece in pieces] == lengths
    for channel in ("time", "displacement", "force", "current"):
        assert np.array_equal(joined(pieces, channel), getattr(whole, channel)), channel
    assert [piece.name for piece in pieces] == [f"long_{k + 1}" for k in range(len(lengths))]
    assert {(p.specimen, p.measurement_session, p.role) for p in pieces} == {("no. 7", "day 1", "validation")}
    assert pieces[1].provenance["piece_of"] == "long"
    assert pieces[1].provenance["piece"] == f"2 of {len(lengths)}"
    assert pieces[0].history[-1].startswith(f"piece 1 of {len(lengths)} of long, 0 to ")


def test_a_sample_on_the_edge_begins_the_next_piece_at_any_offset() -> None:
    whole = record(11.0, 0.001)  # the seventh piece of 1.1 s begins at 7.7000000000000002 s or so
    for offset in (0.0, 0.1, 0.3, 1234.567):
        pieces = cut(whole.replace(note="", time=whole.time + offset), 1.1)
        assert [piece.n for piece in pieces] == [1100] * 10


def test_a_short_record_comes_back_as_it_is() -> None:
    whole = record(4.0)
    assert cut(whole, 5.0)[0] is whole
    assert cut(whole, "events")[0] is whole


def test_ten_pieces_or_more_are_listed_in_order() -> None:
    assert [p.name for p in cut(record(12.0), 1.0)][:2] == ["long_01", "long_02"]


@pytest.mark.parametrize("noise", [0.0, 3e-6])
def test_events_are_cut_in_the_middle_of_the_rests(noise: float) -> None:
    dt, rng = 0.005, np.random.default_rng(2)
    rest, wave = np.zeros(600), 0.008 * np.sin(2 * np.pi * 0.5 * dt * np.arange(1600))
    short = np.zeros(100)  # half a second: no rest
    x = np.concatenate([rest, wave, rest, wave, short, wave, rest, 2 * wave, rest])
    x = x + noise * rng.standard_normal(x.size)
    whole = Record(dt * np.arange(x.size), x, np.zeros(x.size), name="day")
    pieces = cut(whole, "events")
    assert [p.name for p in pieces] == ["day_1", "day_2", "day_3"]
    assert np.array_equal(joined(pieces, "time"), whole.time)
    edges = [600 + 1600 + 300, 600 + 1600 + 600 + 1600 + 100 + 1600 + 300]
    # with noise the ends of a wave hide in it for some samples
    assert [p.time[0] / dt for p in pieces[1:]] == pytest.approx(edges, abs=1 if noise == 0.0 else 15)
    assert "cut at rests of 1 s or more" in pieces[1].history[-1]


@pytest.mark.parametrize(
    ("by", "words"),
    [
        ("five", r"cut by 'five' is not possible; give a duration such as '5 s', or 'events'"),
        (0.0, r"cut by 0 s is not possible; a duration must be finite and greater than 0"),
        ("3 mm", r"cut by '3 mm' is not possible"),
        (0.05, r"long: cut every 0\.05 s, a piece would have 5 samples and needs 8; give a longer duration"),
    ],
)
def test_what_cannot_be_cut(by: float | str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        cut(record(4.0), by)


def test_a_folder_is_cut_as_it_is_read_and_a_file_is_not(tmp_path: Path) -> None:
    path = write(record(), tmp_path / "long.h5")
    pieces = read_campaign(tmp_path, cut="10 s")
    assert [piece.name for piece in pieces] == [piece.name for piece in cut(read(path), 10.0)] == ["long_1", "long_2"]
    assert [piece.name for piece in read_campaign(tmp_path, options=ReadOptions(cut=10.0))] == ["long_1", "long_2"]
    with pytest.raises(InputError, match=r"cut = 'events' makes several records of one file; read it without"):
        read(path, cut="events")
    with pytest.raises(InputError, match=r"cut by 'five' is not possible; give a duration"):
        read_campaign(tmp_path, cut="five")
    write(record(4.0).replace(note="named", name="long_1"), tmp_path / "other.h5")
    with pytest.raises(
        InputError, match=r"2 records or pieces are called 'long_1'; rename a file, or read them without"
    ):
        read_campaign(tmp_path, cut="10 s")
