"""Files of campaigns over HTTP: they stay in their folder, and are renamed, deleted and read at any size."""

import pytest

pytest.importorskip("fastapi")

SINE = '[[step]]\nkind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\n'


@pytest.mark.parametrize(
    "name",
    [
        "..",
        "a\\b",
        "%2e%2e%2fx",
        *(pytest.param(name, marks=pytest.mark.prove) for name in ("a/b", ".hidden", "../x", "x" * 101)),
    ],
)
def test_campaigns_stay_in_their_folder(client, data, name):
    answer = client.put(f"/api/campaigns/files/{name}", json={"text": SINE})
    assert answer.status_code in (400, 404, 405, 422), answer.text
    assert not list(data.rglob("*.toml"))


def test_a_campaign_is_renamed_and_deleted(client, data):
    text = '[[step]]\nkind = "rest"\nduration = "1 s"\n'
    for name in ("a", "b"):
        assert client.put(f"/api/campaigns/files/{name}", json={"text": text}).status_code == 200
    assert client.post("/api/campaigns/rename", json={"name": "a", "to": "b"}).status_code == 409
    assert client.post("/api/campaigns/rename", json={"name": "x", "to": "y"}).status_code == 404
    assert client.post("/api/campaigns/rename", json={"name": "a", "to": "../c"}).status_code == 400
    assert client.post("/api/campaigns/rename", json={"name": "a", "to": "c"}).status_code == 200
    assert client.delete("/api/campaigns/files/b").status_code == 204
    assert client.get("/api/campaigns/files").json() == ["c"]


def test_a_campaign_file_of_any_size_is_answered(client, data):
    (data / "campaigns").mkdir()
    (data / "campaigns" / "large.toml").write_text("#" * 70_000)
    (data / "campaigns" / "wild.toml").write_text(f"seed = {'9' * 60_000}")
    answer = client.get("/api/campaigns/files/large")
    assert (answer.status_code, answer.json()["detail"][:36]) == (400, "large.toml has 68 KiB, a page edits ")
    assert client.get("/api/campaigns/files/wild").json()["grid"] is None
