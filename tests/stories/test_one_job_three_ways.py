"""The same request in Python, on the command line and over HTTP: the same card, the same JSON, the same page."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi")
from click.testing import CliRunner
from fastapi.testclient import TestClient

from dampyr import identification, show, structures, studies
from dampyr import records as dampyr_records
from dampyr.cli import cli
from dampyr.console import app, job_work
from dampyr.console.job_processes import Jobs
from dampyr.ground_motions import el_centro, synthetic_motions
from dampyr.models import Damper, Interpolation
from dampyr.to_json import plain
from tests.identification.synthetic import sine

pytestmark = pytest.mark.prove

CARD = Damper(
    "dahl",
    {"dahl.kx": Interpolation((0.0, 2.0), (800.0, 1800.0)), "dahl.kw": 200.0, "dahl.rho": 3000.0},
    provenance={"records": "a, b"},
)
NAMES = ("a", "b", "c", "d", "e", "f")
TIMES = re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:?\d\d)?)?")
COMMAND = re.compile(r'<dd class="command">.*</dd>')  # a page says who made it
SECONDS = {"seconds"}  # how long work took


@pytest.fixture(autouse=True)
def _at_one_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages say when they were made."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A data folder: a card, six records at two voltages, and one for validation."""
    (tmp_path / "cards").mkdir()
    CARD.save(tmp_path / "cards" / "mine.toml")
    for k, name in enumerate(NAMES):
        one = sine(CARD, 2.0 * (k % 2), name, 0.004 + 0.001 * k, 0.8 + 0.1 * k, noise=1.0, seed=k)
        dampyr_records.write(one, tmp_path / f"{name}.h5")
    last = sine(CARD, 2.0, "v", 0.006, 1.1, noise=1.0, seed=9).replace(note="held back", role="validation")
    dampyr_records.write(last, tmp_path / "v.h5")
    return tmp_path


@pytest.fixture
def client(data: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    """The console over that folder; its jobs run in this process."""

    def run(jobs: Jobs, job: Any) -> None:
        code = job_work.run(jobs.folder / job.id, lambda _: None)
        jobs._update(job.id, state="failed" if code else "done", ended=0.0)
        with jobs._lock:
            del jobs._running[job.id]

    monkeypatch.setattr(Jobs, "_run", run)
    with TestClient(app(data), base_url="http://127.0.0.1:8077") as made:
        yield made


@pytest.fixture
def done(client: TestClient) -> Callable[[str, dict[str, Any]], tuple[str, dict[str, Any]]]:
    """Start a job and wait for it: its id, and the result's data."""

    def ask(path: str, request: dict[str, Any]) -> tuple[str, dict[str, Any]]:
        answer = client.post(f"/api/{path}", json=request)
        assert answer.status_code == 202, answer.text
        id = answer.json()["id"]
        while (job := client.get(f"/api/jobs/{id}").json())["state"] in ("waiting", "running"):
            pass
        assert job["state"] == "done", job["reason"]
        return id, job["result"]["data"]

    return ask


def command(*words: str | Path) -> Any:
    """What a command prints with --json."""
    ended = CliRunner().invoke(cli, [*map(str, words), "--json"], catch_exceptions=False)
    assert ended.exit_code in (0, 1, 3), ended.output
    return json.loads(ended.stdout)


def timeless(value: Any) -> Any:
    """Without dates, and without how long work took."""
    if isinstance(value, dict):
        return {key: timeless(each) for key, each in value.items() if key not in SECONDS}
    if isinstance(value, list):
        return [timeless(each) for each in value]
    return TIMES.sub("", value) if isinstance(value, str) else value


FOOT = re.compile(r"@page \{ @bottom-left .*")
"""At the foot of a printed page its time stands, too, and processes that were started earlier may have one of their own."""


def read(page: Path | str) -> str:
    text = page.read_text("utf-8") if isinstance(page, Path) else page
    return COMMAND.sub("", TIMES.sub("", FOOT.sub("", text)))


def own(data: Path, *names: str) -> list[dampyr_records.Record]:
    return [dampyr_records.read(data / f"{name}.h5") for name in names]


def keys(*names: str) -> list[str]:
    return [f"data/{name}.h5" for name in names]


def test_identify(data: Path, client: TestClient, done: Any) -> None:
    """A named model with a split, and a record of validation."""
    names = (*NAMES, "v")
    ours = identification.fit(own(data, *names), "dahl", predict=("record",), loss="huber")
    ours.save(data / "ours.toml")
    show.write_page(ours, data / "ours.html")

    files = [data / f"{name}.h5" for name in names]
    said = command(
        "identify", *files, "--model", "dahl", "--predict", "record", "--loss", "huber",
        "--save", data / "said.toml", "--report", data / "said.html",
    )  # fmt: skip
    request = {"records": keys(*names), "model": "dahl", "predict": ["record"], "loss": "huber"}
    id, request = done("identify/jobs", request)
    assert client.post(f"/api/identify/jobs/{id}/card", json={"name": "request"}).status_code == 201

    assert said == request == plain(ours.as_dict())
    assert set(said["validation"]) == {"v"}
    assert said["predictions"][0]["split"] == "record"
    cards = {read(data / name) for name in ("ours.toml", "said.toml", "cards/request.toml")}
    pages = {read(data / "ours.html"), read(data / "said.html"), read(client.get(f"/api/identify/jobs/{id}/page").text)}
    assert (len(cards), len(pages)) == (1, 1)


def test_identify_the_best_model(data: Path, client: TestClient, done: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The card of the best model names the runner-up, whoever asks."""
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0})
    tried = ("dahl", "bingham")
    # compiling counts in the time that a trial may take
    identification.fit(own(data, *NAMES), models=tried)
    ours = identification.fit(own(data, *NAMES), models=tried)
    ours.save(data / "ours.toml")
    words = [word for model in tried for word in ("--try", model)]
    said = command("identify", *(data / f"{name}.h5" for name in NAMES), *words, "--save", data / "said.toml")
    id, request = done("identify/jobs", {"records": keys(*NAMES), "models": list(tried)})
    assert client.post(f"/api/identify/jobs/{id}/card", json={"name": "request"}).status_code == 201
    assert timeless(said) == timeless(request) == timeless(plain(ours.as_dict()))
    texts = [read(data / name) for name in ("ours.toml", "said.toml", "cards/request.toml")]
    assert len(set(texts)) == 1
    assert 'chosen = "the lowest validation error, ' in texts[0]
    assert "runner-up = " in texts[0]


def test_every_split_and_loss_is_offered_on_the_page(client: TestClient) -> None:
    offered = client.get("/api/identify/choices").json()
    choices = {option["name"]: dict(option["choices"] or []) for option in offered["options"]}
    assert list(choices["predict"]) == ["record", "input", "frequency", "amplitude", "waveform", "time"]
    assert list(choices["loss"]) == ["squares", "huber", "l1"]
    for name, words in (choices["predict"] | choices["loss"]).items():
        assert words != name, f"{name} has no words"


def test_validate(data: Path, client: TestClient, done: Any) -> None:
    damper = Damper.load(data / "cards" / "mine.toml")
    ours = identification.validate(damper, own(data, *NAMES), card="mine.toml")
    with show.made_by("a script", [data / "cards" / "mine.toml"]):
        show.write_page(ours, data / "ours.html")
    said = command(
        "validate",
        data / "cards" / "mine.toml",
        *(data / f"{name}.h5" for name in NAMES),
        "--report",
        data / "said.html",
    )
    id, request = done("identify/validations", {"records": keys(*NAMES), "card": "cards/mine.toml"})
    path = str(data / "cards" / "mine.toml")
    assert said == plain(ours.as_dict()) | {"card": path, "forces": []}
    assert request == plain(ours.as_dict())
    assert [one for one, score in request["scores"].items() if score["fitted_on"]] == ["a", "b"]
    shown = read(client.get(f"/api/identify/jobs/{id}/page").text)
    assert shown == read(data / "ours.html") == read(data / "said.html").replace(path, "mine.toml")


@pytest.mark.parametrize("reference", ["raminelli_2020", "records"])
def test_accept(data: Path, client: TestClient, reference: str) -> None:
    """By a published damper, and by records of a reference damper."""
    judged, others = ("a", "b"), ("c", "d")
    by_records = reference == "records"
    against = own(data, *others) if by_records else studies.published_damper(reference)
    options = identification.AcceptOptions(0.2, 5.0, quantities=("extension", "energy"))
    name = "c, d" if by_records else reference
    ours = identification.accept(own(data, *judged), against, options, name)
    show.write_page(ours, data / "ours.html")

    folder = data / "c, d"  # reports are titled by the last part of a path
    folder.mkdir()
    for other in others:
        (folder / f"{other}.h5").write_bytes((data / f"{other}.h5").read_bytes())
    said = command(
        "accept", folder if by_records else reference, *(data / f"{each}.h5" for each in judged),
        "--tolerance", "20%", "--force-slack", "5N", "--judge", "extension", "--judge", "energy",
        "--report", data / "said.html",
    )  # fmt: skip
    params = {
        "key": keys(*judged), "reference": keys(*others) if by_records else reference, "tolerance": 0.2,
        "force_slack": 5.0, "quantities": ["extension", "energy"],
    }  # fmt: skip
    request = client.get("/api/records/acceptance", params=params).json()["data"]
    assert request == plain(ours.as_dict())
    assert said | {"reference": name} == request
    shown = read(client.get("/api/records/acceptance/page", params=params).text)
    assert shown == read(data / "ours.html") == read(data / "said.html").replace(str(folder), name)


def test_simulate(data: Path, client: TestClient, done: Any) -> None:
    damper = Damper.load(data / "cards" / "mine.toml")
    inputs = [0.0, 1.5, structures.control_law("on_off", high=2.0, period=0.01)]
    motion = el_centro().scaled_to_pga(2.0)
    ours = structures.respond(structures.two_storey(), motion, {1: damper, 2: damper}, voltage=inputs)
    with show.made_by("a script", [data / "cards" / "mine.toml"]):
        show.write_page(ours, data / "ours.html")
    said = command(
        "simulate", data / "cards" / "mine.toml", "--voltage", "0", "--voltage", "1.5", "--control", "on_off:period=10ms",
        "--storey", "1", "--storey", "2", "--pga", "2 m/s^2", "--report", data / "said.html",
    )  # fmt: skip
    request = {
        "motion": {"pga": 2.0},
        "damper": {"name": "cards/mine.toml", "storeys": [1, 2], "inputs": [0.0, 1.5], "laws": ["on_off:period=10ms"]},
    }
    id, request = done("building/responses", request)
    assert said == request == plain(ours.as_dict())
    assert list(said) == ["no damper", "0 V", "1.5 V", "on_off 0 to 2 V, period 0.01 s"]
    shown = read(client.get(f"/api/building/jobs/{id}/page").text)
    assert read(data / "ours.html") == read(data / "said.html") == shown


def test_ensemble(data: Path, client: TestClient, done: Any) -> None:
    damper = Damper.load(data / "cards" / "mine.toml")
    ours = structures.ensemble(
        structures.two_storey(), synthetic_motions(3, 3, 4.0), [None, damper], voltage=[0.0, 1.5], scales=(0.5, 1.0, 2.0),
        limits="10mm", seed=3,
    )  # fmt: skip
    with show.made_by("a script", [data / "cards" / "mine.toml"]):
        show.write_page(ours, data / "ours.html")
    said = command(
        "ensemble", data / "cards" / "mine.toml", "--voltage", "0", "--voltage", "1.5", "--without-damper",
        "--synthetic", "3", "--duration", "4", "--seed", "3", "--scale", "0.5,1,2", "--limit", "10mm",
        "--report", data / "said.html",
    )  # fmt: skip
    request = {
        "motion": {"kind": "kanai_tajimi", "seed": 3, "duration": 4.0}, "motions": 3, "seed": 3, "scales": [0.5, 1.0, 2.0],
        "limits": ["10mm"], "damper": {"name": "cards/mine.toml", "inputs": [0.0, 1.5]},
    }  # fmt: skip
    id, request = done("building/ensembles", request)
    assert said == request == plain(ours.as_dict())
    shown = read(client.get(f"/api/building/jobs/{id}/page").text)
    assert read(data / "ours.html") == read(data / "said.html") == shown


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: identification.FitOptions(loss="cubes"), "squares, huber, l1"),
        (lambda: identification.FitOptions(predict=("weather",)), "waveform"),
        (lambda: identification.FitOptions(fixed={"dahl.kx": 1.0}).check_of_model(None), "need a model"),
        (lambda: identification.FitOptions(models=("bingham",)).check_of_model("dahl"), "exclude each other"),
        (lambda: identification.FitOptions(starts=0), "starts = 0 is not allowed; it must be at least 1"),
        (lambda: identification.ScoreOptions(settling=-1.0), "settling = -1 s is not allowed"),
        (lambda: identification.AcceptOptions(quantities=("colour",)), "extension, compression, energy"),
        (lambda: structures.RespondOptions(accuracy="vague"), "strict, fast"),
        (lambda: structures.RespondOptions(draws=3), "draws = 3 is not allowed; it must be at least 20"),
        (lambda: structures.EnsembleOptions(intensity="loudness"), "pga, sa, scale"),
        (lambda: structures.EnsembleOptions(precision=16), "64, 32"),
        (lambda: structures.EnsembleOptions(limits=("colour=3mm",)), "drift"),
        (lambda: structures.EnsembleOptions(limits="12"), "'12' has no unit"),
    ],
)
def test_a_wrong_option_is_a_sentence(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()
