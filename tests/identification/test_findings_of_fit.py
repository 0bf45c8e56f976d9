"""What is known to be wrong with records and fits is said by everything that is made of them: once, in the same words."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.identification.synthetic import sine

from dampyr.cli import cli
from dampyr.findings import OF_DAMPER, handed_on
from dampyr.identification import Fit, accept, fit, validate
from dampyr.models import Damper
from dampyr.records import Record, describe, write
from dampyr.show.pages.result_page import write_page

DAHL = Damper("dahl", {"dahl.kx": 1200.0, "dahl.kw": 200.0, "dahl.rho": 2000.0})
SATURATED = "force may be saturated: "


def clipped(name: str = "clipped") -> Record:
    """A sine of 10 mm and 1 Hz of which the load cell shows no more than 210 N, where the damper has 275 N."""
    t = np.arange(0.0, 6.0, 0.005)
    x, v = 0.01 * np.sin(2 * np.pi * t), 0.02 * np.pi * np.cos(2 * np.pi * t)
    force = DAHL.force(t, x, voltage=0.0, velocity=v)
    return Record(t, x, np.clip(force, -210.0, 210.0), velocity=v, voltage=0.0, name=name)


def sprung(name: str, stiffness: float) -> Record:
    """A record with a spring that the model dahl does not have."""
    record = sine(DAHL, 0.0, name=name)
    return record.replace(note="a spring beside it", force=record.force + stiffness * record.displacement)


@pytest.fixture(scope="module")
def of_clipped() -> Fit:
    return fit(clipped(), "dahl")


@pytest.fixture(scope="module")
def missed() -> Fit:
    return fit([sprung("soft", 3e4), sprung("stiff", 9e4)], "dahl")


def test_what_records_lists_is_what_everything_else_says() -> None:
    [finding] = [one for one in clipped().findings if one.severity != "note"]
    assert finding.words.startswith(SATURATED)
    assert finding.about == ("clipped",)
    assert [one["words"] for one in describe(clipped())["findings"]] == [one.words for one in clipped().findings]
    assert f"look at  clipped: {SATURATED}" in " ".join(repr(clipped()).split()).replace("look at", "look at ")


def test_a_saturated_force_is_said_by_the_fit_its_card_and_what_is_made_of_it(of_clipped: Fit, tmp_path: Path) -> None:
    """The fitted kx is 0.057 N s/mm where 1.2 is right, with a misfit of 1.1 %: only the record tells."""
    assert of_clipped.parameters["dahl.kx"] < 100.0
    assert of_clipped.verdict.kind == "good"
    assert str(of_clipped.findings[0]).startswith(f"clipped: {SATURATED}")
    assert of_clipped.as_dict()["findings"] == [one.as_dict() for one in of_clipped.findings]
    assert of_clipped.damper is not None
    card = of_clipped.damper.save(tmp_path / "card.toml")
    assert card.read_text("utf-8").count(SATURATED) == 1
    loaded = Damper.load(card)
    assert tuple(loaded.findings) == tuple(of_clipped.damper.findings)
    assert [str(one) for one in handed_on([loaded], OF_DAMPER)] == [f"the damper's fit: {of_clipped.findings[0]}"]
    assert list(loaded.without().findings) == list(loaded.findings) == list(loaded.at_level(1.1).findings)


@pytest.mark.prove
@pytest.mark.parametrize("page", ["fit", "validate", "accept"])
def test_pages_say_a_saturated_force_once(of_clipped: Fit, tmp_path: Path, page: str) -> None:
    assert of_clipped.damper is not None
    results = {
        "fit": lambda: of_clipped,
        "validate": lambda: validate(of_clipped.damper, [clipped()]),
        "accept": lambda: accept([clipped()], of_clipped.damper),
    }
    write_page(results[page](), tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text("utf-8").count(SATURATED) == 1


def test_records_of_another_damper_and_the_card_are_told_apart(of_clipped: Fit) -> None:
    assert of_clipped.damper is not None
    clean = sine(DAHL, 0.0, name="clean")
    for result in (validate(of_clipped.damper, [clean]), accept([clean], of_clipped.damper)):
        assert [str(one) for one in result.findings] == [f"the damper's fit: {of_clipped.findings[0]}"]
        assert result.as_dict()["findings"] == [of_clipped.findings[0].as_dict() | {"source": "the damper's fit"}]
    by_records = accept([clean], [clipped("reference")])
    assert [one.about for one in by_records.findings] == [("reference",)]


def test_validation_records_are_looked_at_too() -> None:
    result = fit([sine(DAHL, 0.0), clipped().replace(note="kept", role="validation")], "dahl")
    assert [one for one in result.findings if one.words.startswith(SATURATED) and one.about == ("clipped",)]


def test_a_fit_that_misses_the_force_says_so_first_and_its_card_too(missed: Fit, tmp_path: Path) -> None:
    assert missed.converged
    assert np.mean([one.l1 for one in missed.scores.values()]) > 0.2
    assert missed.verdict.kind == "bad"
    assert missed.findings[0].severity == "wrong"
    worst = str(missed.findings[0])
    assert "the model does not describe these records" in worst
    assert "% in stiff" in worst
    assert missed.as_dict()["verdict"] == {"kind": "bad", "words": missed.verdict.words}
    assert any("misses more than noise in 2 of 2 records" in one.words for one in missed.findings)
    assert missed.damper is not None
    assert worst in missed.damper.save(tmp_path / "card.toml").read_text("utf-8")
    assert worst.split(":")[0] in repr(missed.damper)[:200]


@pytest.mark.parametrize(
    ("json_too", "all_of_them"),
    [(False, False), *(pytest.param(json_too, True, marks=pytest.mark.prove) for json_too in (False, True))],
)
def test_every_command_says_what_the_records_have_wrong(tmp_path: Path, json_too: bool, all_of_them: bool) -> None:
    write(clipped(), tmp_path / "clipped.csv")
    card = tmp_path / "card.toml"
    more = ["--json"] if json_too else []

    def said(*words: str | Path) -> str:
        done = CliRunner().invoke(cli, [*map(str, words), *more], catch_exceptions=False)
        assert done.exit_code == 0, done.output
        if words[0] == "export" and not json_too:  # what it prints are paths
            return str(done.stderr)
        assert SATURATED not in done.stderr
        return str(done.stdout)

    files = tmp_path / "clipped.csv", "--voltage", "0"
    of = {"identify": said("identify", *files, "--model", "dahl", "--details", "--save", card)}
    of["validate"] = said("validate", card, *files)
    of["export"] = said("export", card, "--to", "c", "--out", tmp_path)
    if all_of_them:
        of["accept"] = said("accept", card, *files)
        of["simulate"] = said("simulate", card, "--voltage", "0")
        of["ensemble"] = said("ensemble", card, "--voltage", "0", "--out", tmp_path / "peaks.h5")
        of["read"] = said("ensemble", "--read", tmp_path / "peaks.h5")
    assert {command: text.count(SATURATED) for command, text in of.items()} == dict.fromkeys(of, 1)
    if json_too:
        assert json.loads(of["identify"])["verdict"]["kind"] == "good"
    else:
        assert of["identify"].count("assumed between sessions") == 1
        assert (
            "The search converged; misfit 1.1 % of the force (L1 ratio): the model describes this record."
            in of["identify"]
        )


@pytest.mark.parametrize("kind", ["c", "matlab", "opensees"])
def test_exported_text_repeats_the_worst_in_a_comment(of_clipped: Fit, tmp_path: Path, kind: str) -> None:
    from dampyr.export import export

    assert of_clipped.damper is not None
    files = export(of_clipped.damper, kind, tmp_path)
    texts = [path.read_text("utf-8") for path in files if path.suffix in (".h", ".m", ".py", ".tcl")]
    said = [" ".join(text.split()) for text in texts]
    marked = [text for text in said if "Before you use it: the damper's fit: clipped: force may be saturated" in text]
    assert len(marked) == {"c": 1, "matlab": 1, "opensees": 2}[kind]
