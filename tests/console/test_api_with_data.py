"""The API asked about what is there: records, jobs with results, campaigns, a bench whose control is held.

`test_api` asks about names that are not there; here most of what is generated names what is.
"""

import os
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("fastapi")
pytest.importorskip("schemathesis")
import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from schemathesis.checks import not_a_server_error
from schemathesis.python import asgi
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)
from tests.console.layers import state_of
from tests.rig_time import HANG

from dampyr import records
from dampyr.console import app
from dampyr.studies import raminelli_2020

pytestmark = pytest.mark.prove

CHECKS = [not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance]
HERE = {"host": "localhost"}
PAGE = "a-page-of-the-test"
SINE = '[[step]]\nkind = "sine"\namplitude = ["2 mm", "9 mm"]\nfrequency = "1 Hz"\nvoltage = "0.5 V"\n'
BY_SEED = ["kanai_tajimi", "el_centro", "file"]
JOBS = {
    "identify": {"records": ["data/one.csv"], "model": "dahl"},
    "responses": {"motion": {"kind": "kanai_tajimi", "duration": 4}, "damper": {"inputs": [1.0]}},
    "ensembles": {"motion": {"kind": "kanai_tajimi", "duration": 4}, "motions": 3, "damper": {"inputs": [1.0]}},
}
LAST = ("cancel", "DELETE", "disarm", "disconnect")  # what takes things away comes at the end


@pytest.fixture(scope="module")
def full_console(tmp_path_factory, campaign_folder, module_bench_time):
    """A console over a full data folder, with a bench to which one page listens."""
    folder = tmp_path_factory.mktemp("full") / "data"
    fill(folder, campaign_folder)
    jobs = worked(folder)
    made = app(folder, at_once=0, opener=module_bench_time.open, clock=module_bench_time)
    api = schemathesis.openapi.from_asgi("/api/openapi.json", made, headers=HERE)
    with module_bench_time.passing(1.0), asgi.get_client(made) as client:
        own = state_of(made).own
        yield SimpleNamespace(folder=folder, client=client, values=existing_values(jobs), api=api, own=own)


def listens(clients):
    """The page has a stream, and has just been heard."""
    if not clients.knows(PAGE):
        clients.join(PAGE)
    clients.hear(PAGE)


def fill(folder, campaign_folder):
    """A record, a campaign, a card, a motion, a file that is nothing."""
    for name in ("campaigns", "cards", "motions", "uploads"):
        (folder / name).mkdir(parents=True)
    record = records.read_campaign(campaign_folder)[0]
    records.write(record, folder / "one.csv")
    for name in ("up.h5", "last.h5"):  # the first one is renamed on the way
        records.write(record, folder / "uploads" / name)
    (folder / "broken.csv").write_text("time [s],force [N]\n0,1\n0,\n")
    (folder / "campaigns" / "sines.toml").write_text(SINE)
    (folder / "motions" / "quake.csv").write_text("".join(f"{k * 0.02},{0.1 * (-1) ** k}\n" for k in range(100)))
    raminelli_2020.damper().save(folder / "cards" / "one.toml")


def worked(folder):
    """Jobs that are done, one of each kind."""
    made = app(folder, at_once=2)
    with asgi.get_client(made) as client:
        replies = [
            client.post(
                f"/api/{'identify/jobs' if kind == 'identify' else f'building/{kind}'}", json=body, headers=HERE
            )
            for kind, body in JOBS.items()
        ]
        ids = [answer.json()["id"] for answer in replies]
        for _ in range(1200):
            states = [client.get(f"/api/jobs/{id}", headers=HERE).json()["state"] for id in ids]
            if set(states) <= {"done", "failed", "cancelled"}:
                break
            time.sleep(0.2)
    assert states == ["done"] * 3
    return ids


def existing_values(jobs):
    """Values that lead somewhere, by the name of their parameter."""
    keys = ["data/one.csv", "data/uploads/up.h5", "data/broken.csv", "data/cards/one.toml"]
    return {
        "id": jobs, "key": keys, "source": ["data"], "record": ["one"], "records": [[keys[0]], keys[:2], keys],
        "folder": ["sines", "again"], "campaign": ["sines"], "client": [PAGE], "rig": [""],
        "load": ["20 kg", "100 kohm", "0 N"],
        "text": [SINE, SINE + "cycles = 2\n", SINE.replace("sine", "sweep")], "replaces": [SINE, None],
        "model": ["dahl", "dahl + spring", None], "file": ["quake.csv"], "unit": [["force=N"], "g"],
        "tried": [[], ["dahl"]], "predict": ["", "record"], "loss": ["squares"], "bandwidth": [None],
        "card": ["cards/one.toml", "raminelli_2020"], "to": ["c"],
        "reference": [["cards/one.toml"], ["raminelli_2020"], keys[:1]],
        "damper": [{"name": "cards/one.toml", "inputs": [0.0, 3.0], "storeys": [1, 2]}, {"inputs": [9.0]}],
        "command": ["motion", "records", "simulate", "export", "run"],
        "values": [{}, {"paths": keys[:1]}, {"card": "cards/one.toml", "voltages": ["1"]}, {"pga": "0.3g"}],
    }  # fmt: skip


def pointed(case, existing, pick):
    """The case, about what is there: each parameter that has a known value takes one, three times of four."""
    names = existing | {"name": ["sines", "one.csv", "up.h5", "last.h5", "one"], "kind": BY_SEED}
    for part in (case.path_parameters, case.query, case.body):
        if isinstance(part, dict):
            for name in sorted(one for one in part if one in names):
                if pick.random() < 0.75:
                    part[name] = pick.choice(names[name])
    return case


def everything(folder):
    return {Path(place, name).relative_to(folder) for place, _, names in os.walk(folder) for name in names}


def exercise(full_console, operation, examples):
    """Ask one operation that many things; which statuses came back."""
    statuses = []

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck), database=None)
    @given(case=operation.as_strategy(), pick=st.randoms(use_true_random=False))
    def one(case, pick):
        listens(full_console.own["bench"].clients)
        answer = pointed(case, full_console.values, pick).call(session=full_console.client, headers=HERE)
        statuses.append(answer.status_code)
        case.validate_response(answer, checks=CHECKS)
        assert "Traceback" not in answer.content.decode("utf-8", "replace")
        if "json" in answer.headers.get("content-type", [""])[0]:
            assert str(full_console.folder) not in answer.text
        assert [path.name for path in full_console.folder.parent.iterdir()] == ["data"]

    one()
    for job in full_console.client.get("/api/jobs", headers=HERE).json():
        # nobody serves the queue, which is not long; of jobs that have ended the oldest are forgotten, and are asked for here
        if job["state"] == "waiting":
            full_console.client.post(f"/api/jobs/{job['id']}/cancel", headers=HERE)
            full_console.client.delete(f"/api/jobs/{job['id']}", headers=HERE)
    return statuses


def operations(full_console, keep):
    all_operations = [each.ok() for each in full_console.api.get_all_operations()]
    last = [one for word in LAST for one in all_operations if word in (one.method.upper(), *one.path.split("/"))]
    return [one for one in [*(each for each in all_operations if each not in last), *last] if keep(one.path)]


def test_what_is_there_is_told_and_changed_without_a_fault(full_console):
    wanted = operations(full_console, lambda path: "/bench" not in path)
    got = {f"{each.method.upper()} {each.path}": exercise(full_console, each, 20) for each in wanted}
    silent = [name for name, statuses in got.items() if min(statuses) >= 300]
    # their files are bytes: see test_record_uploads and test_building_files; no command has run here: see test_commands
    of_commands = [f"GET /api/commands/jobs/{{id}}/{what}" for what in ("figure", "figures", "file", "page")]
    assert sorted(silent) == [*of_commands, "PUT /api/building/files/{kind}/{name}", "PUT /api/records/uploads/{name}"]
    assert {path.parts[0] for path in everything(full_console.folder)} <= {
        ".console", "broken.csv", "campaigns", "cards", "motions", "one.csv", "uploads",
    }  # fmt: skip


def settled(client):
    """The bench, once it is no more on the way from one state to another; the first rig is compiled before it is connected."""
    until = time.monotonic() + HANG
    while time.monotonic() < until:
        bench_state = client.get("/api/bench", headers=HERE).json()
        if not bench_state["phase"].endswith("ing"):
            return bench_state
        time.sleep(0.05)
    raise AssertionError(bench_state)


# threads of the bench draw from `random` while a request is being drawn
@pytest.mark.filterwarnings("ignore:Do not use the .random. module inside strategies")
def test_a_bench_in_control_takes_any_order_of_anything(full_console):
    """Connected, armed, moving: commands in any state answer or refuse, and abort ends it."""
    wanted = operations(full_console, lambda path: "/bench" in path)
    got = []
    for each in wanted * 2:
        got.append((each.path, exercise(full_console, each, 8)))
        settled(full_console.client)
    full_console.client.post("/api/bench/abort", json={}, headers=HERE)
    bench_state = settled(full_console.client)
    assert bench_state["phase"] in ("idle", "disconnected")
    for name in ("connect", "arm", "control"):
        assert any(200 in statuses for path, statuses in got if path.endswith(name)), got
