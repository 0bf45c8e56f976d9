"""The API of the bench and of the campaigns, without a browser: the stream, what is refused, files that stay where they are."""

import json
from inspect import signature

import pytest

pytest.importorskip("fastapi")
from starlette.websockets import WebSocketDisconnect

from dampyr.console.bench_campaigns import CampaignRuns
from dampyr.console.pages.bench import COMMANDS

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


@pytest.mark.parametrize("path", COMMANDS)
def test_a_command_takes_the_fields_of_its_request(path):
    kind, command, _ = COMMANDS[path]
    parameters = {**signature(command).parameters}
    if parameters.pop("about", None):  # of what is to be run
        parameters |= signature(CampaignRuns.order).parameters
    needed = {name for name, parameter in parameters.items() if parameter.default is parameter.empty}
    assert needed - {"self"} <= kind.model_fields.keys() <= parameters.keys()
