"""Files that are added on the Building page: read first, listed then, and never in the place of one that is there."""

import pytest

pytest.importorskip("fastapi")

import numpy as np

from dampyr.models import Damper

CARD = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 3000.0})
STRUCTURE = b"masses = ['100 kg', '80 kg']\nstiffnesses = ['100 N/mm', '80 N/mm']\ndamping_ratio = 0.02\n"


def put(client, kind, name, content):
    return client.put(f"/api/building/files/{kind}/{name}", content=content)


def test_a_card_a_structure_and_a_motion_are_listed_and_used(client, data, tmp_path):
    CARD.save(tmp_path / "mine.toml")
    t = np.arange(0.0, 2.0, 0.02)
    motion = "time [s],acceleration [m/s2]\n" + "".join(f"{a},{b}\n" for a, b in zip(t, np.sin(9 * t), strict=True))
    for kind, name, content in (
        ("cards", "mine.toml", (tmp_path / "mine.toml").read_bytes()),
        ("structures", "frame.toml", STRUCTURE),
        ("motions", "shake.csv", motion.encode()),
    ):
        answer = put(client, kind, name, content)
        assert answer.status_code == 201, answer.text
        assert answer.json() == {"kind": kind, "name": name}
        assert (data / kind / name).read_bytes() == content
    choices = client.get("/api/building/choices").json()
    assert "cards/mine.toml" in [damper["name"] for damper in choices["dampers"]]
    assert "structures/frame.toml" in choices["structures"]
    assert choices["motions"] == ["shake.csv"]


def test_one_that_is_there_is_not_replaced(client, data, tmp_path):
    CARD.save(tmp_path / "mine.toml")
    content = (tmp_path / "mine.toml").read_bytes()
    assert put(client, "cards", "mine.toml", content).status_code == 201
    again = put(client, "cards", "mine.toml", content + b"\n# another\n")
    assert again.status_code == 409
    assert "there is a file 'mine.toml' among the cards already" in again.json()["detail"]
    assert (data / "cards" / "mine.toml").read_bytes() == content


@pytest.mark.parametrize(
    ("kind", "name", "content", "words"),
    [
        ("cards", "mine.toml", b"model = ", "mine.toml"),
        ("cards", "mine.csv", b"a,b", "must end in .toml"),
        ("structures", "frame.toml", b"[frame]\nmasses = 'many'\n", "frame.toml"),
        ("motions", "shake.csv", b"no numbers at all", "shake.csv"),
        ("motions", "shake.exe", b"0", "must end in"),
        ("cards", "mine.toml", b"", "the file is empty"),
        ("cards", "-mine.toml", b"x", "is not a file name"),
    ],
)
def test_what_is_none_is_refused_in_a_sentence_and_nothing_is_written(client, data, kind, name, content, words):
    answer = put(client, kind, name, content)
    assert answer.status_code == 400, answer.text
    assert words in answer.json()["detail"]
    assert str(data) not in answer.json()["detail"]
    assert not list((data / kind).glob("*")) if (data / kind).exists() else True


def test_no_other_folder_can_be_written(client):
    assert put(client, "uploads", "a.toml", b"x").status_code == 422
    assert put(client, "cards", "..%2Fa.toml", b"x").status_code in (400, 404)
