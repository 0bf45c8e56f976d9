"""The API of the bench and of the campaigns, without a browser: the stream, what is refused, files that stay where they are."""

import json

import pytest

pytest.importorskip("fastapi")
from starlette.websockets import WebSocketDisconnect

from dampyr.console.grid import Grid, grid_of, grid_text

ID = "0123456789abcdef"
SINE = '[[step]]\nkind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\n'
HERE = {"host": "127.0.0.1:8077"}


def stream(client, id=ID, **headers):
    return client.websocket_connect(f"/api/bench/stream?client={id}", headers=HERE | headers)


def state(socket):
    """The next state that is told."""
    while True:
        message = json.loads(socket.receive_text())
        if "frame" in message:
            socket.send_text(json.dumps({"heard": message["frame"]}))
        if message.get("state"):
            return message


def test_a_command_needs_a_stream_and_control(client):
    refused = client.post("/api/bench/connect", json={"client": ID})
    assert refused.status_code == 400
    assert "no open stream" in refused.json()["detail"]
    with stream(client) as first, stream(client, "another-page") as second:
        assert state(first)["holds"]
        message = state(second)
        assert not message["holds"]
        assert message["state"]["holder"] == "page 1"
        refused = client.post("/api/bench/connect", json={"client": "another-page"})
        assert refused.json()["detail"] == "page 1 holds control; take control first"
        assert client.post("/api/bench/control", json={"client": "another-page"}).status_code == 200
        while not state(second)["holds"]:
            pass


def test_another_site_gets_no_stream(client):
    with pytest.raises(WebSocketDisconnect), stream(client, origin="http://evil.example"):
        pass


@pytest.mark.parametrize(
    "words", ["", "[]", "{}", "null", "nonsense", '{"heard": "x"}', '{"jog": null}', '{"heard": 1e9}']
)
def test_a_page_may_say_anything(client, words):
    with stream(client) as socket:
        socket.send_text(words)
        socket.send_text(json.dumps({"abort": 7}))
        while json.loads(socket.receive_text()).get("aborted") != 7:
            pass


def test_abort_asks_nobody(client):
    assert client.post("/api/bench/abort", json={}).json() == {"accepted": True}


def test_a_page_that_hears_nothing_gets_no_more(client):
    with stream(client) as socket:
        frames = [json.loads(socket.receive_text())["frame"] for _ in range(6)]
        assert frames == [1, 2, 3, 4, 5, 6]
        socket.send_text(json.dumps({"abort": 1}))  # what comes next is its answer, and no seventh frame
        assert json.loads(socket.receive_text()) == {"aborted": 1}


@pytest.mark.parametrize("name", ["..", "a/b", ".hidden", "../x", "a\\b", "x" * 101, "%2e%2e%2fx"])
def test_campaigns_stay_in_their_folder(client, data, name):
    answer = client.put(f"/api/campaigns/files/{name}", json={"text": SINE})
    assert answer.status_code in (400, 404, 405, 422), answer.text
    assert not list(data.rglob("*.toml"))


@pytest.mark.parametrize("key", ["rows", "motion"])
@pytest.mark.parametrize("path", ["/etc/passwd", "../../secret.csv"])
def test_a_campaign_reads_no_file_of_elsewhere(client, key, path):
    kind = "earthquake" if key == "motion" else "sine"
    answer = client.post("/api/campaigns/plan", json={"text": f'[[step]]\nkind = "{kind}"\n{key} = "{path}"\n'})
    assert answer.status_code == 400
    assert "is not a valid file name" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[step", "not valid TOML"),
        ("", "there is no step"),
        (SINE + "cycles = 1000000000\n", "shorten it"),
        ('[[step]]\nkind = "reversals"\nhalf_period = "60 s"\ncount = 1000000000\n', "shorten them"),
        (SINE + "repeats = 401\n", "at most 400"),
        (SINE.replace("4 mm", "4 kg"), "amplitude"),
        ("a = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_a_campaign_that_cannot_be_is_one_sentence(client, text, words):
    answer = client.post("/api/campaigns/plan", json={"text": text})
    assert answer.status_code == 400, answer.text
    assert words in answer.json()["detail"]


def test_a_grid_is_its_text_and_back():
    grid = Grid(
        'say "hi"\\',
        "me",
        "two\nlines \x07",
        [2.0, 0.1, 12.4],
        [0.5, 1.0],
        [0.0, 0.8712],
        cycles=7,
        repeats=2,
        random=True,
        seed=3,
    )
    assert grid_of(grid_text(grid)) == grid
    assert grid_of(SINE) == Grid(amplitude=[4.0], frequency=[1.0], voltage=[0.0])
    assert grid_of(SINE + SINE) is None
    assert grid_of(SINE.replace("sine", "sweep")) is None
    assert grid_of(SINE + "taper = 2\n") is None
    assert grid_of('rest_between = "1 s"\n' + SINE) is None


def test_the_plan_is_that_of_the_command_line(client):
    from dampyr.campaigns import campaign_of, plan
    from dampyr.campaigns.force_prediction import specimen
    from dampyr.rig import RigSettings

    rig = RigSettings()
    expected = plan(
        campaign_of({"step": [{"kind": "sine", "amplitude": "9 mm", "frequency": "2 Hz"}]}), rig, specimen(rig)
    )
    reply = client.post(
        "/api/campaigns/plan", json={"text": SINE.replace("4 mm", "9 mm").replace("1 Hz", "2 Hz")}
    ).json()
    assert reply["refusals"] == list(expected.refusals)
    assert reply["tests"][0]["force_N"] == pytest.approx(expected.tests[0].peak_force)
