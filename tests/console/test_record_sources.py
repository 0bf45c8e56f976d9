"""Sources of records: odd names, what cannot be used, interrupted tests, and names that repeat."""

import pytest

pytest.importorskip("fastapi")
from tests.console.record_files import CSV, listed, made

from dampyr import records
from dampyr.console.record_sources import unique_names


@pytest.mark.parametrize(
    "name",
    [
        "#3.csv",
        "50 % & more.csv",
        *(
            pytest.param(name, marks=pytest.mark.prove)
            for name in (
                "0,25 A.csv",
                "O'Neil.csv",
                "run [2].csv",
                "_first.csv",
                "n" * 120 + ".csv",
                "ü.csv",
            )
        ),
    ],
)
def test_a_file_with_an_odd_name_is_listed_and_read(client, data, name):
    (data / name).write_text(CSV)
    (one,) = listed(client)
    assert (one["key"], one["problem"]) == (f"data/{name}", "")
    for what in ("one", "curves", "cycles"):
        assert client.get(f"/api/records/{what}", params={"key": one["key"]}).status_code == 200


def test_what_cannot_be_used_is_listed_with_the_reason(client, data, tmp_path):
    (data / "what?.csv").write_text(CSV)
    (tmp_path / "outside.csv").write_text(CSV)
    (data / "link.csv").symlink_to(tmp_path / "outside.csv")
    said = {one["key"]: one["problem"] for one in listed(client)}
    assert "rename it" in said["data/what?.csv"]
    assert "links are not followed" in said["data/link.csv"]


def test_interrupted_and_repeated_tests_are_marked(client, data):
    folder = data / "runs" / "day"
    folder.mkdir(parents=True)
    for name, attempt, complete in (("a", 1, "no"), ("a-try2", 2, "yes"), ("b", 1, "yes"), ("b-try2", 2, "yes")):
        about = {"test": name[0], "try": str(attempt)} | ({"complete": "no"} if complete == "no" else {})
        records.write(made(name[0], provenance=about), folder / f"{name}.h5")
    marks = {one["key"].rpartition("/")[2]: one["left_out"] for one in listed(client)}
    assert marks == {
        "a.h5": "interrupted: its recording was not completed", "a-try2.h5": "",
        "b.h5": "done again: try 2 of this test is the last", "b-try2.h5": "",
    }  # fmt: skip
    tries = [record.provenance["try"] for record in records.read_campaign(folder)]
    assert tries == ["2", "2"]  # what the command takes


@pytest.mark.prove
def test_records_of_two_runs_with_the_same_names_are_fitted_together(client, data, finished):
    keys = []
    for run in ("monday", "tuesday"):
        folder = data / "runs" / run
        folder.mkdir(parents=True)
        records.write(made("01-sine"), folder / "01-sine.h5")
        keys.append(f"data/runs/{run}/01-sine.h5")
    job = finished(client.post("/api/identify/jobs", json={"records": keys, "model": "bingham"}).json()["id"])
    assert job["state"] == "done", job["reason"]
    assert job["result"]["records"] == ["01-sine (monday)", "01-sine (tuesday)"]


def test_names_that_repeat_are_told_apart_by_as_little_as_is_needed():
    keys = ["data/x/a.h5", "data/y/a.h5", "data/y/b.h5"]
    assert unique_names(["a", "a", "b"], keys) == ["a (x)", "a (y)", "b"]
    assert unique_names(["a", "a"], ["data/x/a.h5", "data/x/a-try2.h5"]) == ["a (a.h5)", "a (a-try2.h5)"]
    assert unique_names(["a", "a"], ["data/x/1/a.h5", "data/y/1/a.h5"]) == ["a (data/x/1/a.h5)", "a (data/y/1/a.h5)"]
