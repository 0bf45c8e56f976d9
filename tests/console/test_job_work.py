"""A job's work in this process: what comes of it in its folder, and what it sends."""

import json

import pytest

pytest.importorskip("fastapi")

from dampyr import registry
from dampyr.console import job_work
from dampyr.console.building_schemas import ResponseRequest
from dampyr.console.identify_schemas import IdentifyRequest
from dampyr.console.job_work import WORK
from dampyr.console.safe_paths import OWN
from dampyr.errors import DampyrWarning


@pytest.fixture
def work(data):
    """``work(kind, request)``: the exit code, what was sent, and the folder of the job."""

    def do(kind, request):
        folder = data / OWN / "jobs" / "0123456789abcdef"
        folder.mkdir(parents=True)
        (folder / "request.json").write_text(json.dumps({"kind": kind, "request": request}))
        sent = []
        code = job_work.run(folder, sent.append)
        return code, sent, folder

    return do


class Kind:
    """A kind of job that reports progress, warns twice of the same, and gives a number."""

    @staticmethod
    def run(request, folder, progress):
        import warnings

        for k in range(1000):
            progress("counting", k / 1000)
        progress("counting", 1.0)
        for _ in range(2):
            warnings.warn(DampyrWarning("the rig is warm"), stacklevel=1)
        return {"number": request["number"] + 1}


def test_a_result_its_warnings_and_few_lines_of_progress(work, monkeypatch):
    monkeypatch.setattr(registry, "member", lambda group, name: {(WORK, "count"): Kind}[group, name])
    code, sent, folder = work("count", {"number": 41})
    assert code == 0
    assert json.loads((folder / "result.json").read_text()) == {"number": 42, "warnings": ["the rig is warm"]}
    assert sent[0] == {"stage": "counting", "progress": 0.0}
    assert sent[-1] == {"stage": "counting", "progress": 1.0}
    assert len(sent) < 100  # at most every tenth of a second, of a thousand that were reported


@pytest.mark.parametrize(("error", "code"), [(MemoryError(), 2), (ZeroDivisionError("a fault"), 1)])
def test_what_is_not_a_persons_error_has_a_code_of_its_own(work, monkeypatch, error, code):
    class Broken:
        @staticmethod
        def run(*_):
            raise error

    monkeypatch.setattr(registry, "member", lambda *_: Broken)
    ended, sent, folder = work("broken", {})
    assert ended == code
    assert ("memory limit" in str(sent)) == (code == 2)
    assert not (folder / "result.json").exists()


def test_only_validation_records_are_refused(work, campaign_folder):
    request = IdentifyRequest(records=["labcontrol/ensaio.vali.1.mat"], model="dahl").model_dump()
    code, sent, _ = work("identify", request)
    assert code == 2
    assert "only validation records" in sent[-1]["reason"]


def test_a_voltage_beyond_the_card_is_refused(work):
    code, sent, _ = work("respond", ResponseRequest(damper={"inputs": [9.0]}).model_dump())
    assert code == 2
    assert "9 V" in sent[-1]["reason"]
