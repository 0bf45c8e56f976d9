"""The files that the console serves, and nothing else."""

import re
from pathlib import Path

import pytest

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient

from dampyr.console import app, application


def test_the_page_answers_a_request_for_its_head(client):
    assert client.head("/").status_code == 200


def test_the_page_holds_no_script_and_names_no_other_machine():
    static = Path(app.__globals__["__file__"]).parent / "static"
    page = (static / "index.html").read_text("utf-8")
    assert not re.search(r"<script(?![^>]*src=)|\son\w+=|style=", page)
    for file in static.rglob("*"):
        if file.suffix in (".html", ".js", ".css"):
            assert not re.search(r"https?://(?!www\.w3\.org)", file.read_text("utf-8")), file


@pytest.mark.parametrize(
    "path", ["/static/../app.py", "/static/%2e%2e/app.py", "/static/..%2fapp.py", "/static//etc/passwd"]
)
def test_static_files_end_at_their_folder(client, path):
    assert client.get(path).status_code == 404


def test_only_the_listed_files_of_the_package_are_served(client, monkeypatch):
    pytest.importorskip("bokeh")
    for name in application.CHARTS:
        answer = client.get(f"/bokeh/{name}")
        assert (answer.status_code, answer.headers["content-type"].partition(";")[0]) == (200, "text/javascript")
        again = client.get(f"/bokeh/{name}", headers={"if-none-match": answer.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    for name in ("bokeh.js", "bokeh-widgets.min.js", "..%2f..%2f__init__.py", "lib/index.js", ""):
        assert client.get(f"/bokeh/{name}").status_code == 404


@pytest.mark.prove
def test_the_description_names_what_every_path_does(data):
    with TestClient(app(data), base_url="http://localhost") as client:
        schema = client.get("/api/openapi.json").json()
    for path, methods in schema["paths"].items():
        assert path.startswith("/api/")
        for one in methods.values():
            assert re.search(r"[.)]$", one["description"].strip()), path
            assert {"400", "404", "422"} <= set(one["responses"])
