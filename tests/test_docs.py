"""What the pages say is so: links lead somewhere, code runs and prints what it says, tables agree with the source."""

from __future__ import annotations

import re
import runpy
import shlex
import subprocess
import sys
import tomllib
import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import click
import numpy as np
import pytest
from tools.page_runner import (
    FENCE,
    FOLLOWED_ELSEWHERE,
    NOT_RUN,
    RUN_KINDS,
    Desk,
    follow,
    is_run,
    lay_out,
    named,
    needs_data,
)  # fmt: skip

from dampyr import registry
from dampyr.channel_columns import NAMES
from dampyr.cli import cli
from dampyr.errors import DampyrWarning
from dampyr.models import Constant, Damper, available_parts
from dampyr.models.part import part
from dampyr.records.record import CHANNELS
from dampyr.structures import available_control_laws, control_law
from dampyr.structures.law_form import SHARED

Array = np.ndarray
ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [*(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")), *sorted(DOCS.rglob("*.md"))]
DATA_KINDS = ("text", "toml", "bash", "c", "matlab")  # files, and what is printed; a file of commands has a name
# Pages whose code compiles or runs for long: proofs.
LONG = (
    "README", "first-damper", "your-own-structure", "ensembles", "control", "rig", "another-laboratory", "ground-motions",
    "campaigns", "acceptance", "read-your-own-files", "hybrid-test", "slurm", "raminelli-2020", "simulated-rig", "export",
    "posterior", "plan-tests", "measurement-sessions", "add-a-control-law", "hybrid-benchmark",
)  # fmt: skip


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a page in one language."""
    return [text for info, text in FENCE.findall(page.read_text(encoding="utf-8")) if info.split(" ")[0] == language]


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


def test_links_lead_somewhere() -> None:
    missing = [
        (name(page), link)
        for page in PAGES
        for link in re.findall(r"\]\(([^)\s]+)\)", FENCE.sub("", page.read_text(encoding="utf-8")))
        if "://" not in link and not (page.parent / link.partition("#")[0]).exists()
    ]
    assert not missing


def test_every_page_is_reached_from_the_list_of_pages() -> None:
    listed = (DOCS / "index.md").read_text(encoding="utf-8")
    pages = [page for page in DOCS.rglob("*.md") if page.parent.name != "decisions" and page.stem != "index"]
    assert not [name(page) for page in pages if f"({page.relative_to(DOCS)})" not in listed]
    assert "(docs/index.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_readme_is_two_screens_long() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 105


def test_lines_are_short_enough_to_read() -> None:
    long = []
    for page in PAGES:
        text = re.sub(r"\]\([^)]*\)", "]", page.read_text(encoding="utf-8"))  # where a link leads is not read
        text = text.partition("<!-- generated: bibliography -->")[0]
        text = re.sub(r"(<!-- generated: [\w-]+ -->).+<!-- end -->", r"\1", text)  # nobody wraps a list that is made
        prose = [line for line in text.splitlines() if line[:1] not in ("|", "$")]
        long += [(name(page), line) for line in prose if len(line) > 145]
    assert not long


def test_every_block_of_a_page_is_run_saved_or_shown() -> None:
    """Nothing that a reader would type hides behind another language or an indentation."""
    hidden = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for info, block in FENCE.findall(text):
            hidden += [(name(page), why, block) for why in hides(info, block)]
        indented = re.findall(r"\n\n((?: {4}|\t)(?:dampyr|make|pip|python|import|from) .*)", FENCE.sub("", text))
        hidden += [(name(page), "indented", line) for line in indented]
    assert not hidden


def hides(info: str, block: str) -> Iterator[str]:
    """What keeps a fenced block from being run or saved though a reader would type it."""
    kind = info.split(" ")[0]
    if kind not in RUN_KINDS + DATA_KINDS:
        yield f"language {info}"
    if kind == "bash" and not named(info, block):
        yield "a script has a name, so that it is saved and run"
    if kind == "text" and re.match(r"(dampyr|make|pip|python|cc|gcc) [a-z-]", block) and ":" not in block[:80]:
        yield "commands as text"
    if kind == "toml":
        try:
            tomllib.loads(block)
        except tomllib.TOMLDecodeError as error:
            yield f"not TOML: {error}"


@pytest.mark.parametrize(
    ("info", "block"),
    [("ruby", "puts 1\n"), ("bash", "echo 1\n"), ("text", "dampyr identify a.csv\n"), ("toml", "a = \n")],
)
def test_a_hidden_block_is_seen(info: str, block: str) -> None:
    assert len(list(hides(info, block))) == 1


def test_every_reason_not_to_run_a_block_is_of_a_block() -> None:
    for page, words in NOT_RUN:
        texts = [text for _, text in FENCE.findall((ROOT / page).read_text(encoding="utf-8"))]
        assert any(text.startswith(words) for text in texts), (page, words)
    reasons = [*NOT_RUN.values(), *FOLLOWED_ELSEWHERE.values()]
    tests = {test for why in reasons for test in re.findall(r"tests/\S+\.py|tests/\w+", why)}
    assert not [each for each in tests if not (ROOT / each.rstrip(",")).exists()]


def is_followed(page: Path) -> bool:
    """Whether a page has anything to run, and no test of its own."""
    return name(page) not in FOLLOWED_ELSEWHERE and is_run(name(page), page.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.prove] * (page.stem in LONG)) for page in PAGES if is_followed(page)],
    ids=name,
)
def test_what_a_page_has_its_reader_do_works(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    text = page.read_text(encoding="utf-8")
    folder = request.getfixturevalue("campaign_folder") if needs_data(text) else None
    lay_out(tmp_path, text, folder)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DAMPYR_DATA", "data")
    monkeypatch.setattr(sys, "path", [*sys.path])
    modules = set(sys.modules)
    for _ in follow(name(page), text, Desk(tmp_path, folder)):
        pass
    for own in {each for each in set(sys.modules) - modules if (tmp_path / f"{each}.py").exists()}:
        del sys.modules[own]


def test_what_a_block_shows_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the site has it below the block: what it prints and its last value, the figures, and pages."""
    monkeypatch.chdir(tmp_path)
    page = (
        "```python\nimport dampyr as dp\n\nmotion = dp.ground_motions.el_centro()\nprint(motion.dt)  # 0.02\nmotion\n```\n"
        "```toml\n# x.toml\na = 1\n```\n"
        "```python\nmotion.plot();\ndp.show.write_page(motion, 'motion.html')\n```\n"
        "```sh\ndampyr motion --report again.html | cat\n```\n"
        "```sh\navrdude\n```\n"
    )
    out = tmp_path / "out"
    out.mkdir()
    first, saved, drawn, typed, left = follow("docs/how-to/firmware.md", page, Desk(tmp_path, None, out))
    assert first is not None
    assert first.text.splitlines()[0] == "0.02"
    assert "GroundMotion" in first.text
    assert not first.figures
    assert saved is None
    assert drawn is not None
    assert drawn.figures[-1][1] == "acceleration [m/s²], velocity [mm/s], displacement [mm] over time [s]"
    assert all((out / file).stat().st_size > 1000 for file, _ in drawn.figures)
    assert drawn.pages == ["02-motion.html"]
    assert typed is not None
    assert typed.text.startswith("El Centro 1940 NS")
    assert typed.pages == ["03-again.html"]
    assert left is not None
    assert left.why_not == "needs an Uno"


def test_what_is_printed_otherwise_than_the_page_says_is_found(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="prints\\n2"):
        Desk(tmp_path, None).execute("print(1 + 1)  # 3\n")
    assert Desk(tmp_path, None, strict=False).execute("print(1 + 1)  # 3\n") == "2\n"


def test_python_in_the_readme_that_needs_no_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Desk(tmp_path, None).execute(blocks(ROOT / "README.md", "python")[0])


FIGURES = [ROOT / "README.md", DOCS / "reference" / "figures.md"]


def table_of(page: Path, heading: str) -> list[list[str]]:
    """The rows of the page's table whose header starts with this text."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith(heading))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            return rows
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def test_the_fits_are_told_as_they_are(campaign_folder: Path) -> None:
    from dampyr.identification import fit
    from dampyr.records import read_campaign

    scores: dict[str, list[float]] = {}
    for record in read_campaign(campaign_folder):
        scores.setdefault(f"{record.voltage:g} V", []).append(fit(record, "dahl").scores[record.name].l1)
    computed = [[volts, str(len(l1)), f"{100 * np.mean(l1):.1f} %"] for volts, l1 in scores.items()]
    assert table_of(FIGURES[1], "| coil | records |") == computed
    told = re.search(r"A Dahl model fitted .* in the\s+mean", FIGURES[0].read_text(encoding="utf-8"), re.DOTALL)
    assert told
    assert re.findall(r"([\d.]+ %) \(\w+ at ([\d.]+ V)\)", " ".join(told[0].split())) == [
        (row[2], row[0]) for row in computed
    ]


def test_the_building_is_told_as_it_is() -> None:
    from dampyr.ground_motions import el_centro
    from dampyr.structures import respond, two_storey
    from dampyr.studies import raminelli_2020

    damper = raminelli_2020.damper()
    rows = table_of(FIGURES[0], "| case |")
    assert table_of(FIGURES[1], "| case |") == rows
    for case, *cells in rows:
        dampers = {} if case == "no damper" else {1: damper}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)
            response = respond(two_storey(), el_centro(), dampers, voltage=float(case.split()[0]) if dampers else None)
        peaks = [float(cell.removesuffix(" mm")) for cell in cells]
        np.testing.assert_allclose(1e3 * response.peak_displacement, peaks, atol=1e-3)


def test_the_times_of_the_readme_are_those_of_the_page() -> None:
    readme, page = (path.read_text(encoding="utf-8") for path in FIGURES)
    [(time, error)] = re.findall(
        r"An ensemble takes (\S+ \S+) per history .* an error of (\S+ %)", readme.replace("\n", " ")
    )
    assert f"| dampyr, fast, peaks of displacement and drift | {time} | 25,000 | {error} |" in page


def test_the_page_of_the_packages_names_every_member() -> None:
    page = (DOCS / "reference" / "packages.md").read_text(encoding="utf-8")
    packages = ("models.parts", "campaigns.steps", "structures.control", "export.kinds", "studies")
    members = [name for package in packages for name in registry.names(f"dampyr.{package}")]
    assert not [each for each in (*members, *cli.list_commands(click.Context(cli))) if f"`{each}`" not in page]


def test_the_card_of_the_reference_loads(tmp_path: Path) -> None:
    [text] = blocks(DOCS / "reference" / "card.md", "toml")
    path = tmp_path / "damper.toml"
    path.write_text(text, encoding="utf-8")
    damper = Damper.load(path)
    assert damper.range == (0.0, 3.0)
    assert damper.bandwidth == 15.0
    assert damper.values(1.0)[1] == pytest.approx(230.0)
    assert damper.covariance is not None
    assert damper.covariance.shape == (10, 10)
    assert tomllib.loads(damper.save(path).read_text(encoding="utf-8")) == tomllib.loads(text)


def commands() -> Iterator[tuple[str, click.Command]]:
    context = click.Context(cli)
    for each in cli.list_commands(context):
        command = cli.get_command(context, each)
        assert command is not None
        yield each, command
        for inner, sub in getattr(command, "commands", {}).items():
            yield f"{each} {inner}", sub


def test_the_reference_names_every_option() -> None:
    text = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    sections = re.split(r"^## ", text, flags=re.MULTILINE)
    missing = []
    for command, what in commands():
        own = [section for section in sections if f"`dampyr {command}" in section.partition("\n")[0]]
        options = [option for p in what.params if isinstance(p, click.Option) and not p.hidden for option in p.opts]
        wanted = [option for option in options if option.startswith("--") and option not in ("--json", "--help")]
        missing += [(command, option) for option in ["", *wanted] if not own or option not in own[0]]
    assert not missing


def test_the_reference_names_no_option_that_is_not_there() -> None:
    text = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    options = {o for _, c in commands() for p in c.params if isinstance(p, click.Option) for o in p.opts}
    assert set(re.findall(r"--[a-z-]+[a-z]", text)) - options == {"--help", "--version"}


def test_the_reference_of_the_models_is_what_the_parts_say() -> None:
    page = (DOCS / "reference" / "models.md").read_text(encoding="utf-8")
    for each in available_parts():
        section = re.split(rf"^## `{each}`$", page, flags=re.MULTILINE)[1].partition("\n## ")[0]
        assert "$$" in section, f"{each} shows no equation"
        assert not re.search(r":math:|\.\. math|``", section)
        for key, quantity in part(each).parameters.items():
            assert f"| `{key}` | {quantity.unit or '1'} | {quantity.range_in_words()} |" in section


def test_the_generated_lists_and_pages_are_up_to_date(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tool = ROOT / "tools" / "make_docs.py"
    monkeypatch.syspath_prepend(tool.parent)
    monkeypatch.setattr(sys, "argv", [str(tool), "--check"])
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(tool), run_name="__main__")
    assert not end.value.code, capsys.readouterr().out + "run make docs"


def test_the_generated_lists_are_markdown() -> None:
    pages = [DOCS / "reference" / f"{page}.md" for page in ("campaign-file", "control-laws", "formats", "studies")]
    left = [(name(page), re.findall(r":math:|\.\. math|``(?!`)", page.read_text(encoding="utf-8"))) for page in pages]
    assert not [each for each in left if each[1]]


def test_the_refusal_of_the_how_to_is_what_is_said(tmp_path: Path) -> None:
    from dampyr.campaigns import plan

    page = DOCS / "how-to" / "campaigns.md"
    [text] = blocks(page, "text")
    (tmp_path / "too_fast.toml").write_text(blocks(page, "toml")[1], encoding="utf-8")
    [refusal] = plan(tmp_path / "too_fast.toml").refusals
    assert " ".join(text.split()) == f"dampyr: {refusal}"


def test_the_reference_names_every_control_law_and_its_settings() -> None:
    text = (DOCS / "reference" / "control-laws.md").read_text(encoding="utf-8")
    rows = {line.split("`")[1]: line for line in text.splitlines() if line.startswith("| `")}
    for law in available_control_laws():
        settings = vars(control_law(law, high=1.0)).keys() - set(SHARED)
        assert all(f"`{name}`" in rows[law] for name in settings), law


def test_the_reference_names_every_channel_of_a_file() -> None:
    record_file = (DOCS / "reference" / "record-file.md").read_text(encoding="utf-8")
    columns = (DOCS / "reference" / "csv.md").read_text(encoding="utf-8")
    assert not [channel for channel in CHANNELS if f"/calibrated/{channel}`" not in record_file]
    for channel, unit in CHANNELS.items():
        assert f"| {channel} | {', '.join(f'`{word}`' for word in NAMES[channel])} | {unit} |" in columns


def test_the_reference_of_the_record_file_is_what_is_written(tmp_path: Path) -> None:
    import h5py

    from dampyr.records import Record, write
    from dampyr.records.record import Label

    t = np.linspace(0.0, 1.0, 50)
    label = Label(0.01, 1.0, "4.2", 3)
    record = Record(
        t, t, t, velocity=t, voltage=1.0, temperature=t, label=label, provenance={"by": "hand"}, history=("a",)
    )
    path = write(record, tmp_path / "test.h5")
    text = (DOCS / "reference" / "record-file.md").read_text(encoding="utf-8")
    paths: list[str] = []
    with h5py.File(path) as file:
        file.visit(paths.append)
        attributes = [*file.attrs, *file["label"].attrs]
    assert not [each for each in paths if f"/{each}" not in text]
    assert not [each for each in attributes if f"`{each}`" not in text]
    for place in re.findall(r'h5read\("test.h5", "([^"]+)"\)', text):
        assert place[1:] in paths


@pytest.mark.prove
def test_the_model_of_the_how_to_is_a_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from dampyr.identification import fit
    from dampyr.models import parts
    from dampyr.records import Record

    [text] = blocks(DOCS / "how-to" / "add-a-model.md", "python")
    (tmp_path / "bent_dashpot.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(parts, "__path__", [*parts.__path__, str(tmp_path)])
    assert "bent_dashpot" in available_parts()
    t = np.linspace(0.0, 6.0, 1200)
    x, v = 0.01 * np.sin(6.0 * t), 0.06 * np.cos(6.0 * t)
    force = 20.0 + 3000.0 * v / (1 + np.abs(v) / 0.04)
    fit_result = fit(Record(t, x, force, velocity=v, voltage=0.0), "bent_dashpot")
    np.testing.assert_allclose(list(fit_result.parameters.values()), [3000.0, 0.04], rtol=1e-5)
    sys.modules.pop("dampyr.models.parts.bent_dashpot")


def test_the_c_of_the_how_to_compiles_and_runs(tmp_path: Path) -> None:
    import shutil

    from dampyr.export import export

    if shutil.which("gcc") is None:
        pytest.skip("gcc is missing: the C of the how-to cannot be compiled")
    page = DOCS / "how-to" / "export.md"
    numbers = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 20e3}
    damper = Damper("dahl", {each: Constant(value, 0.0, 3.0) for each, value in numbers.items()})
    export(damper, "c", tmp_path)
    [program] = blocks(page, "c")
    (tmp_path / "main.c").write_text(program, encoding="utf-8")
    [line] = [text for text in blocks(page, "sh") if text.startswith("cc ")]
    subprocess.run(["gcc", *shlex.split(line)[1:]], cwd=tmp_path, check=True)
    out = subprocess.run([str(tmp_path / "a.out")], capture_output=True, text=True, check=True).stdout
    t = np.linspace(0.0, 1.0, 1001)
    expected = 800.0 * 0.005 + 50.0 * (1 - np.exp(-20e3 * 0.005))
    assert float(out) == pytest.approx(expected, rel=1e-9)
    assert damper.force(t, 0.005 * t, voltage=1.0)[-1] == pytest.approx(expected, rel=1e-9)


def test_every_bench_is_found_and_has_its_two_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    benches = dict(registry.members("benchmarks"))
    assert len(benches) >= 5
    assert all(isinstance(bench.TITLE, str) and callable(bench.run) for bench in benches.values())
    assert "datasets fetch" in benches["campaign_fit"].run(None)


def test_the_faults_of_the_simulated_rig_are_all_listed() -> None:
    from dampyr.rig.simulation.faults import KINDS

    page = (DOCS / "reference" / "simulated-rig.md").read_text(encoding="utf-8").partition("## What may go wrong")[2]
    assert re.findall(r"^\| `([\w-]+)` \|", page, re.MULTILINE) == list(KINDS)
    for name, fault in KINDS.items():
        assert f"| `{name}` | {fault.words} |" in page


def test_what_contributing_names_is_there() -> None:
    """Each module of a shared type, and each folder in which a new member is a file."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for name, module in re.findall(r"^\| `([A-Z]\w+)`.*?\| `(dampyr[\w.]+)` \|", text, re.MULTILINE):
        assert hasattr(import_module(module), name), f"{module}.{name}"
    for place in re.findall(r"`((?:\w+/)+)NAME", text):
        assert (ROOT / "src" / "dampyr" / place).is_dir() or place == "show/PACKAGE/", place
    for file in re.findall(r"`?((?:tests|tools)/[\w/]+\.py)", text):
        assert (ROOT / file).is_file(), file
