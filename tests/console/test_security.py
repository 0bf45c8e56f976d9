"""Who may ask the console, and what it tells those who may not."""

import socket
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocketDisconnect
from tests.console.coroutines import result_of

from dampyr.console import app
from dampyr.console.security import HEADERS, MAX_BODY, MAX_UPLOAD, UPLOAD, BodyLimit, HostCheck, TokenBrake, is_loopback

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
@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "DELETE", "OPTIONS"])
def test_another_site_is_refused(client, origin, method):
    answer = client.request(method, "/api/console", headers={"origin": origin})
    assert answer.status_code == 403
    assert "access-control-allow-origin" not in answer.headers


@pytest.mark.parametrize("origins", [(HERE, "http://evil.example"), ("http://evil.example", HERE)])
def test_two_origins_are_no_own_one(client, origins):
    assert client.get("/api/console", headers=[("Origin", origin) for origin in origins]).status_code == 403


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


def test_no_other_way_to_write_a_path_goes_around_the_token(guarded):
    held = ("/api/console", "/%61pi/console", "/api/%2e%2e/api/console", "/api//console", "/api", "/apix")
    elsewhere = ("//api/console", "/API/console", "/static/%2e%2e/api/console", "/static//api/console", "/%5capi")
    for method in ("GET", "HEAD", "OPTIONS", "POST", "TRACE"):
        assert {guarded.request(method, path).status_code for path in held} == {401}
        assert {guarded.request(method, path).status_code for path in elsewhere} <= {404, 405}


def test_the_cookie_is_found_among_those_of_others(guarded):
    for cookie in (
        "dampyr_token={}", "a=b;dampyr_token={}; c", 'dampyr_token="{}"', "a/b=1; dampyr_token={}", ";;=; dampyr_token={}",
    ):  # fmt: skip
        assert guarded.get("/api/console", headers={"cookie": cookie.format(TOKEN)}).status_code == 200
        assert guarded.get("/api/console", headers={"cookie": cookie.format("wrong")}).status_code == 401


def test_wrong_tokens_are_braked_by_their_address(data):
    now = [0.0]
    guard = app(data, TOKEN, loopback_only=False, clock=lambda: now[0])
    with TestClient(guard, base_url="http://192.0.2.7:8077") as client:
        stale = {"authorization": "Bearer of-the-console-before"}
        assert {client.get("/api/console", headers=stale).status_code for _ in range(20)} == {401}
        wrong = [{"authorization": f"Bearer wrong-{k}"} for k in range(6)]
        assert [client.get("/api/console", headers=each).status_code for each in wrong] == [401] * 4 + [429] * 2
        refused = client.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"})
        assert (refused.status_code, refused.headers["retry-after"]) == (429, "10")  # nor is a right one looked at
        assert client.get("/?token=wrong-token").status_code == 429
        assert client.post("/api/bench/abort", json={}, headers=wrong[0]).status_code == 401  # which waits for nothing
        assert client.get("/api/console").status_code == 401  # a page that has none yet asks for it
        now[0] = 11.0
        assert client.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200
        assert client.get("/api/console", headers=wrong[0]).status_code == 401


def test_wrong_tokens_of_websockets_are_braked_on_any_path(guarded):
    for k, path in enumerate(("/", "/any", "/api/any", "/static", "//")):
        wrong = {"authorization": f"Bearer wrong-{k}"}
        with pytest.raises(WebSocketDisconnect) as refused, guarded.websocket_connect(path, headers=wrong):
            pass
        assert refused.value.code == 4403
    assert guarded.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 429


def test_as_many_addresses_are_remembered_as_fit_into_a_megabyte(monkeypatch):
    monkeypatch.setattr("dampyr.console.security.MAX_ADDRESSES", 3)
    brake = TokenBrake(None, TOKEN, frozenset(), clock=lambda: 0.0)

    def asks(address, token):
        headers = [(b"authorization", f"Bearer {token}".encode())]
        scope = {"type": "http", "path": "/api", "headers": headers, "client": (address, 5)}
        return brake.answer(HTTPConnection(scope)) is None

    assert [asks("192.0.2.1", f"wrong-{k}") for k in range(6)] == [True] * 5 + [False]
    assert all(asks(f"192.0.2.{k}", "wrong") for k in (2, 3))
    assert not asks("192.0.2.1", TOKEN)
    assert asks("192.0.2.4", "wrong")
    assert asks("192.0.2.1", TOKEN)


def test_another_address_is_not_braked_with_it(guarded):
    for k in range(5):
        guarded.get("/api/console", headers={"authorization": f"Bearer wrong-{k}"})
    assert guarded.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 429
    other = TestClient(guarded.app, "http://192.0.2.7:8077", client=("192.0.2.9", 5))
    assert other.get("/api/console", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_the_token_goes_from_the_address_into_a_cookie(guarded):
    answer = guarded.get(f"/?token={TOKEN}", follow_redirects=False)
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    assert {"HttpOnly", "SameSite=strict"} <= set(answer.headers["set-cookie"].split("; "))
    assert guarded.get("/api/console").status_code == 200


@pytest.mark.parametrize("method", ["HEAD", "POST", "OPTIONS"])
def test_only_who_opens_the_page_gets_the_cookie(guarded, method):
    assert "set-cookie" not in guarded.request(method, f"/?token={TOKEN}", follow_redirects=False).headers


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


def test_what_is_open_here_is_open_to_this_machine_alone(data):
    console = app(data, TOKEN, loopback_only=False)
    there = TestClient(console, "http://192.0.2.7:8077", client=("192.0.2.9", 5))
    with TestClient(console, "http://192.0.2.7:8077", client=("127.0.0.1", 5)) as here:
        assert here.post("/api/bench/abort", json={}).status_code == 200
        assert there.post("/api/bench/abort", json={}).status_code == 401
        assert here.post("/api/bench/abort/", json={}).status_code == 401
        assert here.post("/api/bench/connect", json={}).status_code == 401
        assert here.post("/api/bench/abort", json={}, headers={"origin": "http://evil.example"}).status_code == 403
        assert here.post("/api/bench/abort", json={}, headers={"host": "evil.example"}).status_code == 400


def test_nothing_inline_and_nothing_from_elsewhere_may_run(client):
    for path in ("/", "/static/console.js", "/api/console", "/nothing", "/api/nothing"):
        headers = client.get(path).headers
        policy = dict(part.split(" ", 1) for part in headers["content-security-policy"].split("; "))
        assert policy["default-src"] == "'none'"
        assert policy["script-src"] == policy["style-src"] == "'self'"
        assert policy["frame-ancestors"] == "'none'"
        assert headers["x-content-type-options"] == "nosniff"


def test_every_answer_has_the_headers_refusals_too(guarded):
    evil = {"origin": "http://evil.example"}
    asked = [
        guarded.get("/api/console", headers={"host": "evil.example"}),
        guarded.get("/api/console"),
        guarded.get("/api/console", headers=evil),
        guarded.post("/", content=b"1" * (MAX_BODY + 1)),
        guarded.get(f"/?token={TOKEN}", follow_redirects=False),
        *[guarded.get(f"/?token=wrong-{k}") for k in range(6)],
    ]
    assert {answer.status_code for answer in asked} == {200, 303, 400, 401, 403, 413, 429}
    for answer in asked:
        assert HEADERS.items() <= dict(answer.headers).items()
        assert answer.headers["cache-control"] == ("no-store" if answer.url.path.startswith("/api") else "no-cache")


def test_faults_have_the_headers_too(data, monkeypatch):
    monkeypatch.setattr("dampyr.console.application.full_version", lambda: 1 / 0)
    with TestClient(app(data), base_url=HERE, raise_server_exceptions=False) as client:
        answer = client.get("/api/console")
    assert answer.status_code == 500
    assert HEADERS.items() <= dict(answer.headers).items()


def test_a_large_body_is_refused_announced_or_not(client):
    kind = {"content-type": "application/json"}
    assert (
        client.post("/api/jobs/0123456789abcdef/cancel", content=b"1" * (MAX_BODY + 1), headers=kind).status_code == 413
    )
    answer = client.post("/api/bench/abort", content=iter([b"1" * (MAX_BODY + 1)]), headers=kind)
    assert (answer.status_code, answer.json()) == (413, {"detail": "too large; at most 1 MiB are taken"})


@pytest.mark.parametrize(("kind", "limit"), [(UPLOAD, MAX_UPLOAD), ("application/json", MAX_BODY), ("", MAX_BODY)])
def test_an_unannounced_body_is_counted_as_it_comes(kind, limit):
    scope = {"type": "http", "headers": [(b"content-type", kind.encode()), (b"transfer-encoding", b"chunked")]}
    taken = []

    async def application(scope, receive, send):
        for _ in range(9):
            taken.append(len((await receive())["body"]))

    async def receive():
        return {"type": "http.request", "body": bytes(limit // 4), "more_body": True}

    with pytest.raises(HTTPException, match=f"413: too large; at most {limit // 2**20} MiB are taken"):
        result_of(BodyLimit(application)(scope, receive, None))
    assert sum(taken) == limit


@pytest.mark.parametrize("length", ["-1", "1e3", str(MAX_UPLOAD + 1), "x"])
def test_an_announced_length_that_makes_no_sense_is_refused(client, length):
    answer = client.post("/api/console", headers={"content-length": length, "content-type": UPLOAD})
    assert answer.status_code == 413


@pytest.mark.parametrize("loopback_only", [True, False])
def test_what_is_more_than_a_host_and_its_port_is_none(loopback_only):
    check = HostCheck(None, loopback_only)
    for host in (
        "127.0.0.1?evil", "127.0.0.1#evil", "127.0.0.1\\evil", "127.0.0.1,evil", "127.0.0.1 evil", "@127.0.0.1", "[127.0.0.1]",
        "evil@127.0.0.1", "127.0.0.1:0", "127.0.0.1:-1", "127.0.0.1:80:80", "127.0.0.1:65536", "127.0.0.1:\xb2", "::1", "null",
        "localhost.", "127.1", "0x7f000001", "2130706433", "%31%32%37.0.0.1", "[v1.x]",
    ):  # fmt: skip
        refused = check.answer(HTTPConnection({"type": "http", "headers": [(b"host", host.encode("latin-1"))]}))
        assert refused is not None, host


@given(st.text(max_size=40), st.booleans())
def test_no_host_makes_the_check_stumble(host, loopback_only):
    scope = {"type": "http", "headers": [(b"host", host.encode("latin-1", "replace"))]}
    refusal = HostCheck(None, loopback_only).answer(HTTPConnection(scope))
    assert refusal is None or refusal.status_code == 400


def test_loopback_is_told_by_its_number():
    assert all(map(is_loopback, ("127.0.0.1", "127.9.9.9", "::1", "[::1]", "localhost")))
    assert not any(map(is_loopback, ("0.0.0.0", "::", "128.0.0.1", "localhost.evil.example", "", "127.1.evil")))
