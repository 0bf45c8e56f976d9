"""The endpoints of the Records page: no key and no file leads out of the data."""

import pytest

pytest.importorskip("fastapi")
from tests.console.record_files import everything, upload
from tests.records.test_self_contained import PLANTS, planted

NO_KEYS = ["data/../x.csv", "labcontrol/../SOURCES.md", "data//etc/passwd", "nowhere/a.mat", "data/x.csv", "x"]


@pytest.mark.parametrize(
    "names", [list(PLANTS)[:2], pytest.param(list(PLANTS)[2:], marks=pytest.mark.prove)], ids=["two", "the others"]
)
def test_files_that_point_out_of_themselves_show_nothing(client, data, tmp_path, names):
    """Neither uploaded nor put into the data folder by hand."""
    answers = []
    for number, plant in enumerate(PLANTS[name] for name in names):
        (folder := tmp_path / "sent" / str(number)).mkdir(parents=True)
        path = planted(folder / f"test {number}.h5", plant)
        refused = upload(client, path.name, path.read_bytes())
        assert refused.status_code == 400
        answers.append(refused)
    assert everything(data) == []
    for path in (tmp_path / "sent").glob("*/test *.h5"):
        (data / path.name).write_bytes(path.read_bytes())
        answers += [
            client.get(f"/api/records/{each}", params={"key": f"data/{path.name}", "format": "csv"})
            for each in ("one", "curves", "cycles", "export")
        ]
    listed = client.get("/api/records/list")
    assert sum("copy it with h5repack" in one["problem"] for one in listed.json()) == len(names)
    for answer in (listed, *answers):
        assert not any(secret in answer.text for secret in ("777.25", "778.25", "password"))
        assert "copy it with h5repack" in answer.text


@pytest.mark.parametrize(
    ("path", "key"),
    [
        pytest.param(path, key, marks=[pytest.mark.prove] * (k > (2 if path == "one" else 0)))
        for path in ("one", "curves", "cycles", "export")
        for k, key in enumerate([*NO_KEYS, "data/.console/notes.json"])
    ],
)
def test_a_key_never_leads_out(client, campaign_folder, key, path):
    answer = client.get(f"/api/records/{path}", params={"key": key, "format": "csv"})
    assert answer.status_code in (400, 404, 422)
    assert "/" not in answer.json()["detail"].replace(key, "").replace(key.partition("/")[2], "").replace("by /", "")
