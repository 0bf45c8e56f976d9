"""The API keeps to its own description, whatever it is asked: no 500, no traceback, nothing written outside."""

import pytest

pytest.importorskip("fastapi")
pytest.importorskip("schemathesis")
import schemathesis
from hypothesis import HealthCheck, given, settings
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from dampyr.console import app

CHECKS = [not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A data folder with nothing beside it."""
    return tmp_path_factory.mktemp("api") / "data"


@pytest.fixture(scope="module")
def api(folder):
    """The console with a queue that nobody serves: what is asked for is checked, and not computed."""
    return schemathesis.openapi.from_asgi("/api/openapi.json", app(folder, at_once=0), headers={"host": "localhost"})


def exercise(api, folder, examples, leave_out=""):
    """Ask every path that many things that its description allows or forbids."""
    for result in api.get_all_operations():
        operation = result.ok()
        if leave_out and leave_out in operation.path:
            continue

        @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck))
        @given(case=operation.as_strategy())
        def one(case):
            answer = case.call(headers={"host": "localhost"})
            case.validate_response(answer, checks=CHECKS)
            assert "Traceback" not in answer.text
            assert str(folder) not in answer.text
            assert [path.name for path in folder.parent.iterdir()] == ["data"]

        one()


@pytest.mark.prove
def test_every_path_keeps_to_its_description(api, folder):
    exercise(api, folder, 3, leave_out="uploads")  # these are tried with bytes of their own in test_record_uploads


@pytest.mark.prove
def test_every_path_keeps_to_its_description_at_length(api, folder):
    exercise(api, folder, 6)
