"""Names from outside never lead out of the data folder."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("fastapi")

from dampyr.console import safe_paths
from dampyr.errors import InputError, MissingData


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../x", "a/../../x", "/etc/passwd", "a//b/../..", "a\\b", ".console/jobs", "a/.hidden", "x\0y", "a\nb",
     " a", "a ", "a.", "~x", "C:x", "C:\\x", "a" * 256, "a/" * 400 + "b", "-rf", "con|x", "x\u202etxt"],
)  # fmt: skip
def test_a_name_that_leads_elsewhere_is_refused(tmp_path, name):
    with pytest.raises(InputError):
        safe_paths.inside(tmp_path, name)


@pytest.mark.parametrize(
    "name",
    ["test 1.csv", "lab/0.25A_2Hz (second).mat", "ensaio.A.1.mat", "Prüfung/Versuch+3.h5", "a/b/c", "0,25 A.csv", "#3.csv",
     "O'Neil.csv", "run [2].csv", "50 % & more.csv", "_first.csv", "a" * 150 + ".csv"],
)  # fmt: skip
def test_ordinary_names_are_taken(tmp_path, name):
    assert safe_paths.inside(tmp_path, name) == tmp_path / name


@pytest.mark.parametrize("name", ["con", "NUL.csv", "Com1.tar.gz", "lpt9 .toml", "aux"])
def test_a_device_of_windows_is_no_new_name_and_what_has_one_is_still_read(tmp_path, name):
    assert not safe_paths.is_new_name(name)
    assert safe_paths.new_name(name) == ""
    with pytest.raises(InputError, match="is the name of a device on Windows"):
        safe_paths.check_new_name(name)
    assert safe_paths.inside(tmp_path, name) == tmp_path / name
    safe_paths.check_new_name(f"the {name}")


def test_links_are_not_followed(tmp_path):
    (tmp_path / "outside.csv").write_text("secret")
    root = tmp_path / "data"
    root.mkdir()
    (root / "link.csv").symlink_to(tmp_path / "outside.csv")
    (root / "up").symlink_to(tmp_path)
    for name in ("link.csv", "up/outside.csv"):
        with pytest.raises(InputError, match="link"):
            safe_paths.existing(root, name)
    assert safe_paths.files(root, (".csv",)) == []
    why = "it is a link, and links are not followed; copy the file itself"
    assert safe_paths.left_out(root, (".csv",)) == {"link.csv": why, "up": why}


def test_what_is_not_shown_is_named_with_the_reason(tmp_path):
    for name in ("a.csv", "what?.csv", "-rf.csv", ".hidden.csv", "what?.txt"):
        (tmp_path / name).write_text("1,2")
    assert safe_paths.files(tmp_path, (".csv",)) == ["a.csv"]
    said = safe_paths.left_out(tmp_path, (".csv",))
    assert set(said) == {"-rf.csv", "what?.csv"}
    assert all("rename it" in why for why in said.values())


@pytest.mark.parametrize(
    ("name", "stored"),
    [
        ("Prüfstand 3, Dämpfer ü.csv", "Prüfstand 3_ Dämpfer ü.csv"), ("#1: a|b.csv", "1_ a_b.csv"),
        ("a" * 200 + ".csv", "a" * 87 + ".csv"), ("???.csv", ""),
    ],
)  # fmt: skip
def test_a_name_from_elsewhere_becomes_one_that_every_system_allows(name, stored):
    assert safe_paths.new_name(name) == stored


@given(st.text(alphabet=st.sampled_from("ab./\\ ~:-\0é"), max_size=12))
def test_whatever_is_asked_stays_inside(name):
    root = Path("/data/root")
    try:
        path = safe_paths.inside(root, name)
    except InputError:
        return
    assert path.is_relative_to(root)
    assert path != root
    assert ".." not in path.parts


def test_a_file_that_is_not_there_is_missing(tmp_path):
    with pytest.raises(MissingData, match=r"x\.csv: there is no such file"):
        safe_paths.existing(tmp_path, "x.csv")


def test_the_quota_counts_every_file(tmp_path):
    (tmp_path / ".console").mkdir()
    (tmp_path / ".console/x").write_bytes(b"1" * 700)
    (tmp_path / "y").write_bytes(b"1" * 200)
    safe_paths.check_quota(tmp_path, 100, 1000)
    with pytest.raises(InputError, match="quota"):
        safe_paths.check_quota(tmp_path, 101, 1000)
