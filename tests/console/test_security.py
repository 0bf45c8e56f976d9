"""Who may ask the console, and what it tells those who may not."""

import socket
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from dampyr.console import app
from dampyr.console.security import MAX_BODY, MAX_UPLOAD, UPLOAD, Rules, is_loopback

HERE = "http://127.0.0.1:8077"
TOKEN = "a-token-of-some-length"


@pytest.fixture
def guarded(data: Path):
    """A console on an address that others reach."""
    with TestClient(app(data, TOKEN, loopback_only=False), base_url="http://192.0.2.7:8077") as test_client:
        yield test_client


@pytest.mark.parametrize("host", ["127.0.0.1:8077", "localhost:8077", "[::1]:8077", "127.0.0.1", "localhost:1"])
def test_the_names_of_this_machine_are_known(client, host):
    assert client.get("/api/console", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example", "192.0.2.7:8077", "localhost.evil.example", "", "127.0.0.1@evil.example",
     "127.0.0.1:99999", "[::1", "localhost/evil.example"],
)  # fmt: skip
def test_a_foreign_name_is_refused_even_if_it_leads_here(client, host):
    answer = client.get("/api/console", headers={"host": host})
    assert answer.status_code == 400
    assert answer.json() == {"detail": "this console does not have that name; open it at the address that it printed"}


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9", "http://localhost:8077", "file://"]
)
@pytest.mark.parametrize("method", ["GET", "POST", "DELETE", "OPTIONS"])
def test_another_site_is_refused(client, origin, method):
    answer = client.request(method, "/api/console", headers={"origin": origin})
    assert answer.status_code == 403
    assert "access-control-allow-origin" not in answer.headers


def test_the_console_itself_is_let_in(client):
    assert client.get("/api/console", headers={"origin": HERE, "sec-fetch-site": "same-origin"}).status_code == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_link_from_elsewhere_opens_the_page_and_nothing_more(client, site):
    led = {"sec-fetch-site": site, "sec-fetch-mode": "navigate"}
    assert client.get("/", headers=led).status_code == 200
    assert client.get("/api/console", headers=led).status_code == 403
    assert client.get("/", headers=led | {"sec-fetch-mode": "no-cors"}).status_code == 403


@pytest.mark.parametrize("headers", [{"origin": "http://evil.example"}, {"host": "evil.example"}])
def test_a_websocket_of_another_site_is_not_opened(client, headers):
    with pytest.raises(WebSocketDisconnect) as refused, client.websocket_connect("/api/any", headers=headers):
        pass
    assert refused.value.code == 4403


def test_elsewhere_the_token_decides(guarded):
    assert guarded.get("/api/console").status_code == 401
    assert guarded.get("/api/console", headers={"authorization": "Bearer wrong"}).status_code == 401
    assert guarded.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200
    with pytest.raises(WebSocketDisconnect), guarded.websocket_connect("/api/any"):
        pass


def test_wrong_tokens_are_braked_by_their_address(data):
    now = [0.0]
    guard = app(data, TOKEN, loopback_only=False)
    guard.brake.clock = lambda: now[0]
    with TestClient(guard, base_url="http://192.0.2.7:8077") as client:
        stale = {"authorization": "Bearer of-the-console-before"}
        assert {client.get("/api/console", headers=stale).status_code for _ in range(20)} == {401}
        wrong = [{"authorization": f"Bearer wrong-{k}"} for k in range(6)]
        assert [client.get("/api/console", headers=each).status_code for each in wrong] == [401] * 4 + [429] * 2
        refused = client.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"})
        assert (refused.status_code, refused.headers["retry-after"]) == (429, "10")  # nor is a right one looked at
        assert client.get("/?token=wrong-token").status_code == 429
        assert client.get("/api/console").status_code == 401  # a page that has none yet asks for it
        now[0] = 11.0
        assert client.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200
        assert client.get("/api/console", headers=wrong[0]).status_code == 401


def test_the_token_goes_from_the_address_into_a_cookie(guarded):
    answer = guarded.get(f"/?token={TOKEN}", follow_redirects=False)
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    assert {"HttpOnly", "SameSite=strict"} <= set(answer.headers["set-cookie"].split("; "))
    assert guarded.get("/api/console").status_code == 200


def test_a_wrong_token_in_the_address_gives_no_cookie(guarded):
    assert "set-cookie" not in guarded.get("/?token=wrong", follow_redirects=False).headers
    assert guarded.get("/api/console").status_code == 401


def test_a_page_of_another_site_cannot_enter_with_a_token_it_knows(guarded):
    answer = guarded.get(f"/?token={TOKEN}", headers={"host": "evil.example"}, follow_redirects=False)
    assert "set-cookie" not in answer.headers


def test_addresses_and_the_own_name_are_known_elsewhere_and_foreign_names_are_not(guarded):
    tell = {"authorization": f"Bearer {TOKEN}"}
    assert guarded.get("/api/console", headers=tell | {"host": socket.gethostname()}).status_code == 200
    assert guarded.get("/api/console", headers=tell | {"host": "evil.example"}).status_code == 400


def test_what_is_open_here_is_open_to_this_machine_alone():
    rules = Rules(TOKEN, False, frozenset({"/api/bench/abort"}))
    scope = {"type": "http", "method": "POST", "path": "/api/bench/abort", "headers": [(b"host", b"192.0.2.7")]}
    assert rules.refusal(scope | {"client": ("127.0.0.1", 5)}) is None
    assert rules.refusal(scope | {"client": ("192.0.2.9", 5)})[0] == 401
    assert rules.refusal(scope | {"client": ("127.0.0.1", 5), "path": "/api/bench/arm"})[0] == 401
    foreign = [*scope["headers"], (b"origin", b"http://evil.example")]
    assert rules.refusal(scope | {"client": ("127.0.0.1", 5), "headers": foreign})[0] == 403


def test_nothing_inline_and_nothing_from_elsewhere_may_run(client):
    for path in ("/", "/static/console.js", "/api/console", "/nothing", "/api/nothing"):
        headers = client.get(path).headers
        policy = dict(part.split(" ", 1) for part in headers["content-security-policy"].split("; "))
        assert policy["default-src"] == "'none'"
        assert policy["script-src"] == policy["style-src"] == "'self'"
        assert policy["frame-ancestors"] == "'none'"
        assert headers["x-content-type-options"] == "nosniff"


def test_a_large_body_is_refused_announced_or_not(client):
    kind = {"content-type": "application/json"}
    assert (
        client.post("/api/jobs/0123456789abcdef/cancel", content=b"1" * (MAX_BODY + 1), headers=kind).status_code == 413
    )
    pieces = (b"1" * 65536 for _ in range(MAX_BODY // 65536 + 1))
    assert client.post("/api/records/notes", content=pieces, headers=kind).status_code in (404, 405, 413)


@pytest.mark.parametrize("length", ["-1", "1e3", str(MAX_UPLOAD + 1), "x"])
def test_an_announced_length_that_makes_no_sense_is_refused(client, length):
    answer = client.post("/api/console", headers={"content-length": length, "content-type": UPLOAD})
    assert answer.status_code == 413


@given(st.text(max_size=40))
def test_no_host_makes_the_rules_stumble(host):
    scope = {"type": "http", "method": "GET", "path": "/", "headers": [(b"host", host.encode("latin-1", "replace"))]}
    refusal = Rules(None).refusal(scope)
    assert refusal is None or refusal[0] == 400


def test_loopback_is_told_by_its_number():
    assert all(map(is_loopback, ("127.0.0.1", "127.9.9.9", "::1", "[::1]", "localhost")))
    assert not any(map(is_loopback, ("0.0.0.0", "::", "128.0.0.1", "localhost.evil.example", "", "127.1.evil")))
