"""One campaign on the simulated rig, and every face of what is made of it: each says that nothing was measured."""

from __future__ import annotations

import inspect
import json
import pkgutil
import re
import shutil
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

import h5py
import pytest
from click.testing import CliRunner

import dampyr as dp
from dampyr import registry
from dampyr.campaigns.journal import Journal, journal_origin
from dampyr.cli import cli
from dampyr.errors import DampyrWarning, InputError
from dampyr.export import available_kinds
from dampyr.identification import fit
from dampyr.identification.model_choice.leaderboard import leaderboard
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Damper, published
from dampyr.origin import NOTICES, ORIGIN_KINDS, SIMULATED, Origin, as_origin, combined, of_board
from dampyr.records import Record, convert, read, read_campaign, write
from dampyr.records.files.record_files import REGISTRY as FORMATS
from dampyr.show import pages
from dampyr.show.descriptions import description_of
from dampyr.show.pages import result_page
from dampyr.shown import Shown
from dampyr.source_digest import full_version
from tests.stories.figure_texts import PICTURES, texts_alone

CAMPAIGN = """
name = "one"
operator = "operator on duty"
specimen = "MR-7"
measurement_session = "mounting 3"
rest_between = "1 s"
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "2 Hz"
voltage = ["0 V", "1.98 V"]
cycles = 3
"""
NOTICE, WORD = NOTICES["simulated"], "SIMULATED"
STATED = {
    "operators": ["operator on duty"],
    "specimens": ["MR-7"],
    "sessions": ["mounting 3"],
    "versions": [full_version()],
}
SHAKE = ("--voltage", "1.98", "--allow-extrapolation")
ENSEMBLE = (*SHAKE, "--synthetic", "3", "--duration", "3", "--scale", "0.5:1:0.5", "--limit", "12mm")


@dataclass(frozen=True)
class Made:
    """The folder of the campaign and the card that was identified from it, with the records that both come from."""

    folder: Path
    card: Path
    records: list[Record]
    plain: list[Record]

    def call(self, *words: str | Path) -> str:
        done = CliRunner().invoke(cli, [*map(str, words)], catch_exceptions=False)
        assert done.exit_code in (0, 1, 3), done.output  # accept judges
        return done.stdout

    @property
    def files(self) -> dict[str, str]:
        """The SHA-256 of each record's file, by the file's name."""
        return {path.name: sha256(path.read_bytes()).hexdigest() for path in self.folder.glob("*.h5")}


def origins(data: Any) -> list[dict[str, Any]]:
    """Every origin in data as JSON has them."""
    if isinstance(data, list):
        return [origin for each in data for origin in origins(each)]
    if not isinstance(data, dict):
        return []
    return [
        origin
        for name, each in data.items()
        for origin in ([each] if name in ("origin", "damper_origin") else origins(each))
    ]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    lab = tmp_path_factory.mktemp("simulated")
    (lab / "campaign.toml").write_text(CAMPAIGN)
    ran = CliRunner().invoke(cli, ["run", str(lab / "campaign.toml"), "--out", str(lab / "records")])
    assert ran.exit_code == 0, ran.output
    assert ran.stdout.splitlines()[0] == NOTICE
    records = read_campaign(lab / "records")
    identified = ["identify", str(lab / "records"), "--model", "dahl", "--save", str(lab / "card.toml")]
    assert CliRunner().invoke(cli, identified, catch_exceptions=False).exit_code == 0
    plain = [record.replace(note="as if measured", name=f"real {record.name}", origin="measured") for record in records]
    return Made(lab / "records", lab / "card.toml", records, plain)


def test_the_file_the_journal_and_the_card_say_it(made: Made) -> None:
    assert [record.origin.kind for record in made.records] == ["simulated"] * 2
    for record in made.records:
        with h5py.File(made.folder / f"{record.name}.h5") as file:
            assert file.attrs["origin"] == "simulated"
    assert journal_origin(made.folder).kind == "simulated"
    assert any(event.detail.endswith("; simulated") for event in Journal(made.folder).events())
    assert Damper.load(made.card).origin.kind == "simulated"
    assert made.card.read_text().startswith(f"# {NOTICE}.\n")


@pytest.mark.parametrize("to", [name for name, module in registry.members(FORMATS) if hasattr(module, "write")])
def test_each_format_that_is_written_brings_it_back(made: Made, tmp_path: Path, to: str) -> None:
    path = convert(made.records[:1], tmp_path, to)[0]
    units = {} if to != "mat" else {"displacement": "mm", "velocity": "mm/s", "force": "N"}
    assert read(path, voltage=made.records[0].voltage, units=units).origin.kind == "simulated"


def specimens_twice(m: Made) -> list[Any]:
    """Of the campaign and a copy of it, so that there is a trend to be drawn."""
    copy = shutil.copytree(m.folder, m.folder.with_name("copy"), dirs_exist_ok=True)
    return ["specimens", m.folder, copy]


COMMANDS: dict[str, Callable[[Made], list[Any]]] = {
    "records": lambda m: ["records", m.folder],
    "records of one": lambda m: ["records", m.folder / f"{m.records[0].name}.h5"],
    "identify": lambda m: ["identify", m.folder, "--model", "dahl"],
    "identify --each": lambda m: ["identify", m.folder, "--model", "dahl", "--each"],
    "validate": lambda m: ["validate", m.card, m.folder],
    "accept": lambda m: ["accept", m.card, m.folder],
    "specimens": specimens_twice,
    "cycles": lambda m: ["cycles", m.folder],
    "simulate": lambda m: ["simulate", m.card, *SHAKE],
    "ensemble": lambda m: ["ensemble", m.card, *ENSEMBLE],
    "ride": lambda m: ["ride", m.card, "--voltage", "1.98", "--seeds", "1", "--length", "50"],
    "arena": lambda m: ["arena", m.card, "--voltage", "1.98", *ENSEMBLE],
    "arena --search": lambda m: ["arena", m.card, "--search", "voltage=1,1.98", "--synthetic", "4", "--duration", "2"],
    "run": lambda m: ["run", m.folder.parent / "campaign.toml", "--out", m.folder],
    "plan": lambda m: ["plan", "--card", m.card, "--tests", "1", "--seconds", "4", "--kind", "sine", "--at", "1.98"],
    "export": lambda m: ["export", m.card, "--to", "c", "--out", m.folder.parent / "c"],
}
ELSEWHERE = {
    "demo": "stories/test_the_chain",
    "hybrid": "below", "serve": "forces over a wire; its JSON has damper_origin",
    "reproduce": "published numbers and records",
    "calibrate": "a calibration, no record", "console": "below", "datasets": "no record", "doctor": "no record",
    "help": "no record", "licences": "no record", "motion": "a ground motion",
    "posterior": "cli/test_posterior: these two records determine nothing",
    "judge": "campaigns/test_judgement", "protocol": "campaigns/test_protocol_result",
}  # fmt: skip


def test_no_command_is_forgotten() -> None:
    assert {name.split()[0] for name in COMMANDS} | ELSEWHERE.keys() == set(cli.list_commands(None))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_says_it_first_and_in_json(made: Made, printed: Printed, name: str) -> None:
    words = COMMANDS[name](made)
    said = json.loads(made.call(*words, "--json"))
    stated = [
        origin for origin in origins(said) if name != "simulate" or origin["sources"]
    ]  # not of the case without a damper
    assert {origin["kind"] for origin in stated} == {"simulated"}
    files = {one: digits for one, digits in made.files.items() if name != "records of one" or one.startswith("01")}
    if name != "run":  # the journal states the kind; its records state the rest
        assert {name: sorted({each for origin in stated for each in origin[name]}) for name in STATED} == STATED
        assert {file["name"]: file["sha256"] for origin in stated for file in origin["sources"]} == files
        assert all(origin["dates"] == [str(datetime.now(UTC).date())] for origin in stated)
    if name == "export":  # what it prints are paths
        return
    lines = printed.of(COMMANDS[name]).splitlines()
    assert lines[0] == NOTICE
    assert lines.count(NOTICE) == sum(line.strip().startswith("─") for line in lines) or "of one" in name


PAGES: dict[str, Callable[[Made], list[Any]]] = {
    "fit_page": COMMANDS["identify"],
    "validate_page": COMMANDS["validate"],
    "acceptance_page": COMMANDS["accept"],
    "specimens_page": COMMANDS["specimens"],
    "cycles_page": COMMANDS["cycles"],
    "response_page": COMMANDS["simulate"],
    "ensemble_page": COMMANDS["ensemble"],
    "arena_page": COMMANDS["arena"],
    "search_page": COMMANDS["arena --search"],
}


def test_no_page_is_forgotten() -> None:
    other = {
        "plan_page",
        "motion_page",
        "hybrid_page",
        "judgement_page",
        "protocol_page",
        "posterior_page",
    }  # no records; no damper; below; their own tests
    assert PAGES.keys() | other == set(result_page.PAGES.values())
    modules = {module.name for module in pkgutil.iter_modules(pages.__path__) if module.name.endswith("_page")}
    assert modules - {"html_page", "result_page"} == set(result_page.PAGES.values())


RENDERED = "ensemble_page"
"""The page with the fewest figures, which `make test` renders; of the others it looks at the texts of the figures."""


@pytest.mark.parametrize(
    "name", [RENDERED, *(pytest.param(n, marks=pytest.mark.prove) for n in PAGES if n != RENDERED)]
)
def test_each_page_and_each_of_its_figures_says_it(made: Made, tmp_path: Path, name: str) -> None:
    page, figures = tmp_path / "page.html", tmp_path / "figures"
    made.call(*PAGES[name](made), "--report", page, "--figures", figures)
    _looks_right(page, figures)
    _states_its_records(page, made)


@pytest.mark.parametrize("name", PAGES)
def test_each_page_and_each_of_its_figures_says_it_in_its_texts(made: Made, printed: Printed, name: str) -> None:
    printed.of(PAGES[name])
    _looks_right(printed.page(PAGES[name]), printed.figures(PAGES[name]))
    _states_its_records(printed.page(PAGES[name]), made)


def _states_its_records(page: Path, made: Made) -> None:
    html = page.read_text("utf-8")
    assert "measured</text>" not in html  # no curve is called so
    for words in ("operator operator on duty", "specimen MR-7", "session mounting 3"):
        assert f"<li>{words}</li>" in html
    for file, digits in made.files.items():
        assert f'<span>{file}</span> <code>{digits[:12]}<span class="rest">{digits[12:]}</span></code>' in html


class Printed:
    """What the commands print, each run once; those that have a page leave it, with the texts of its figures."""

    def __init__(self, made: Made, folder: Path) -> None:
        self.made, self.folder, self.texts = made, folder, dict[str, str]()

    def of(self, words: Callable[[Made], list[Any]]) -> str:
        """What the command of these words prints."""
        name = self.name(words)
        if name not in self.texts:
            faces = ("--report", self.page(words), "--figures", self.figures(words)) if words in PAGES.values() else ()
            with texts_alone():
                self.texts[name] = self.made.call(*words(self.made), *faces)
        return self.texts[name]

    def name(self, words: Callable[[Made], list[Any]]) -> str:
        """Which of the commands these words are."""
        return next(name for name, of_command in COMMANDS.items() if of_command is words)

    def page(self, words: Callable[[Made], list[Any]]) -> Path:
        """The file of its page."""
        return self.folder / f"{self.name(words)}.html"

    def figures(self, words: Callable[[Made], list[Any]]) -> Path:
        """The folder of its figures."""
        return self.folder / f"{self.name(words)} figures"


@pytest.fixture(scope="module")
def printed(made: Made, tmp_path_factory: pytest.TempPathFactory) -> Printed:
    return Printed(made, tmp_path_factory.mktemp("pages"))


def _looks_right(page: Path, figures: Path | None, said: str = NOTICE) -> None:
    html = page.read_text("utf-8")
    body = html[html.index("<body>") :]
    assert said in body[: body.index("<h1>")]
    word = said.partition(":")[0]
    drawn = re.findall(r"<svg.*?</svg>", body, re.DOTALL)
    assert drawn
    assert all(f"{word}</text>" in svg for svg in drawn)
    files = [*figures.glob("*.svg")] if figures else []
    assert len(files) == (len(drawn) if figures else 0)
    for one in files:
        assert f"{word}</text>" in one.read_text("utf-8"), one
        assert word in one.with_suffix(".csv").read_text("utf-8"), one


def _objects(made: Made) -> dict[str, Any]:
    result = fit(made.records, "dahl")
    assert result.damper is not None
    building, motion = dp.structures.two_storey(), dp.ground_motions.el_centro()
    with pytest.warns(DampyrWarning, match="calibrated up to"):
        simulated = dp.structures.respond(building, motion, result.damper, voltage=[1.98], allow_extrapolation=True)
    return {
        "record": made.records[0], "fit": result, "residuals": result.residuals, "damper": result.damper,
        "validated": dp.identification.validate(result.damper, made.records),
        "accepted": dp.identification.accept(made.records, result.damper),
        "acceptance": dp.identification.accept(made.records[0], result.damper).results[0],
        "simulated": simulated, "response": simulated.cases["1.98 V"],
    }  # fmt: skip


def test_each_object_says_it_and_each_of_its_plots(made: Made) -> None:
    from matplotlib import pyplot

    drawn = 0
    for name, one in _objects(made).items():
        assert isinstance(one, Shown)
        origin: Origin = one.origin  # type: ignore[attr-defined]
        assert origin.kind == "simulated", name
        assert {each: list(getattr(origin, each)) for each in STATED} == STATED, name
        assert {file.name: file.sha256 for file in origin.sources}.items() <= made.files.items(), name
        assert origin.sources
        assert NOTICE in repr(one), name
        figure = description_of(one).figure
        with texts_alone():
            assert figure is None or figure() is None or f"{WORD}</text>" in one._repr_html_(), name
        plots = one.plot  # type: ignore[attr-defined]
        for each, method in inspect.getmembers(plots, inspect.ismethod):
            if each.startswith("_") or each in ("measured_and_fitted", "steady_cycle"):
                continue
            axes = method(made.records[0].name) if name == "validated" and each != "scores" else method()
            assert WORD in [text.get_text() for text in axes[0].figure.texts], (name, each)
            pyplot.close("all")
            drawn += 1
    assert drawn >= 18


@pytest.mark.parametrize("kind", available_kinds())
def test_each_export_says_it(made: Made, tmp_path: Path, kind: str) -> None:
    import zipfile

    damper = Damper.load(made.card)
    files = dp.export.export(damper, kind, tmp_path)
    if kind == "fmu":
        with zipfile.ZipFile(files[0]) as archive:
            texts = [archive.read("modelDescription.xml").decode()]
    else:
        with_heads = ("damper.h", "damper.c", "damper.m", "damper.py", "damper.tcl", "damper.mo")
        texts = [path.read_text("utf-8") for path in files if path.name in with_heads]
    assert texts
    assert all(NOTICE in text for text in texts)
    heads = [" ".join(re.sub(r"\n *([*%#]|//)", " ", text).split()) for text in texts]
    stated = "operator: operator on duty; specimen: MR-7; session: mounting 3;"
    assert any(stated in head and all(digits[:12] in head for digits in made.files.values()) for head in heads)


def test_the_console_says_it_in_its_lists_and_results(made: Made, tmp_path: Path) -> None:
    pytest.importorskip("fastapi")
    import shutil

    from dampyr.campaigns.run_folders import run_folder
    from dampyr.console import record_answers
    from dampyr.console.dampers import dampers
    from dampyr.console.jobs import identify, respond

    assert run_folder(made.folder).origin.kind == "simulated"
    shutil.copytree(made.folder, tmp_path / "records" / "one")
    (tmp_path / "cards").mkdir()
    shutil.copy(made.card, tmp_path / "cards" / "mine.toml")
    job = tmp_path / "console" / "jobs" / "1"
    job.mkdir(parents=True)
    links = {link.name: link for link in dampers(tmp_path)}
    assert (links["cards/mine.toml"].title, links["cards/mine.toml"].origin.kind) == ("mine (simulated)", "simulated")
    assert record_answers.description(made.records[0])["origin"]["kind"] == "simulated"
    keys = [f"data/records/one/{record.name}.h5" for record in made.records]
    tell = lambda stage, done: None  # noqa: E731
    request = {"damper": {"name": "cards/mine.toml", "inputs": [1.98]}, "allow_extrapolation": True}
    with texts_alone():
        identified = identify.run({"records": keys, "model": "dahl"}, job, tell)
        with pytest.warns(DampyrWarning, match="calibrated up to"):
            responded = respond.run(request, job, tell)
    assert (identified["notice"], responded["notice"]) == (NOTICE, NOTICE)
    assert identified["data"]["origin"]["kind"] == "simulated"


@pytest.mark.parametrize("pictures", PICTURES)
def test_a_virtual_hybrid_test_is_virtual_everywhere(
    tmp_path: Path, pictures: Callable[[], AbstractContextManager[None]]
) -> None:
    said, page, figures = NOTICES["virtual"], tmp_path / "hybrid.html", tmp_path / "figures"
    words = ["hybrid", "--delay", "0.01", "--voltage", "1.98", "--duration", "4", "--report", str(page)]
    with pictures():
        done = CliRunner().invoke(cli, [*words, "--figures", str(figures)], catch_exceptions=False)
    assert done.stdout.splitlines()[0] == said
    assert "virtual hybrid test" in done.stdout
    _looks_right(page, figures, said)
    text = page.read_text("utf-8")
    assert "measured" not in re.sub(r"<style>.*?</style>", "", text[text.index("<body>") :].replace(said, ""))
    assert "No rig took part" in text
    assert "none: the damper is its model" in text
    for name in ("virtual hybrid test:", "virtual</text>"):
        assert name in text  # legends
    output = CliRunner().invoke(cli, [*words[:7], "--json"], catch_exceptions=False).stdout
    assert json.loads(output)["origin"]["kind"] == "virtual"


def test_simulated_and_other_records_are_fitted_together_only_by_name(made: Made, tmp_path: Path) -> None:
    both = [*made.records, *made.plain]
    for others in (made.plain, [one.replace(note="", origin="not stated") for one in made.plain]):
        with pytest.raises(InputError, match=r"\(simulated\).*are not fitted together.*--mixed-origins"):
            fit([*made.records, *others], "dahl")
    for refused in (fit, leaderboard, lambda records: cross_validate(records, "dahl")):
        with pytest.raises(InputError, match="mixed_origins=True"):
            refused(both)
    mixed = fit(both, "dahl", mixed_origins=True)
    assert mixed.damper is not None
    assert (mixed.origin.kind, mixed.damper.provenance["origins"]) == ("simulated", "2 simulated, 2 measured")
    for record in both:
        write(record, tmp_path / f"{record.name}.h5")
    words = ["identify", str(tmp_path), "--model", "dahl"]
    refused = CliRunner().invoke(cli, words)
    assert refused.exit_code == 2
    assert "--mixed-origins" in refused.stderr
    assert CliRunner().invoke(cli, [*words, "--mixed-origins"]).stdout.splitlines()[0] == NOTICE


def test_only_what_all_measured_is_measured(made: Made, tmp_path: Path) -> None:
    def of(*kinds: str) -> str:
        return combined(as_origin(kind) for kind in kinds).kind

    assert of("measured", "measured") == "measured"
    assert of("measured", "not stated") == of() == of("measured", "derived") == "not stated"
    assert of("measured", "simulated", "virtual") == "simulated"
    assert of("measured", "virtual") == "virtual"
    measured = fit(made.plain, "dahl")
    assert measured.origin.kind == "measured"
    assert "origin" not in repr(measured)  # nothing is said where nothing is wrong
    for to in ("h5", "csv", "mat", "nc", "parquet"):
        assert read(convert(made.plain[:1], tmp_path, to)[0], voltage=0.0).origin.kind == "measured"


def test_what_says_nothing_is_not_stated(tmp_path: Path) -> None:
    t = dp.studies.raminelli_2020.damper()
    x = [0.001 * k % 7 for k in range(20)]
    record = Record([0.01 * k for k in range(20)], x, x)
    assert record.origin.kind == "not stated"
    path = write(record, tmp_path / "plain.csv")
    assert "origin" not in path.read_text()
    assert read(path).origin.kind == "not stated"
    path.write_text(f"# origin: our laboratory\n{path.read_text()}")  # somebody else's words
    assert read(path).origin.kind == "not stated"
    assert t.origin.kind == "derived"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # of unusual values
        assert all(published.damper(name).origin.kind == "derived" for name in published.available_sets())
    assert Damper("dahl", {"dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 1.0}).origin.kind == "not stated"
    with pytest.raises(InputError, match=f"choose from {', '.join(ORIGIN_KINDS)}"):
        record.replace(note="", origin="real")


def test_records_of_before_are_recognised_by_their_board(made: Made, tmp_path: Path) -> None:
    record = made.records[0]
    boards = {"PCI-6221 01A2B3C4, Uno firmware 2.0": "simulated", "simulated OUR-BOARD 7": "simulated",
              "PCI-6221 01B00000, Uno firmware 2.0": "not stated"}  # fmt: skip
    for board, origin in boards.items():
        assert of_board(board).kind == origin
        path = tmp_path / f"{origin} {len(board)}.h5"
        write(record.replace(note="", provenance=dict(record.provenance) | {"board": board}), path)
        with h5py.File(path, "a") as file:
            del file.attrs["origin"]  # dampyr 0.2.0 wrote none
        assert read(path).origin.kind == origin


def test_a_figure_is_stamped_once() -> None:
    from matplotlib.figure import Figure

    figure = Figure()
    for _ in range(2):
        SIMULATED.stamp(figure)
    assert [text.get_text() for text in figure.texts] == [WORD]
    assert not Origin("measured").stamp(Figure()).texts
