"""Every command of the terminal on a page of the console: as a form that performs it, or with the reason why not."""

import shutil
from pathlib import Path

import click
import pytest

pytest.importorskip("fastapi")
from tests.example_folder import fill_example_folder

from dampyr.cli import cli, command_forms
from dampyr.console.command_words import (
    FILES,
    GROUPS,
    NOT_OFFERED,
    PAGES,
    CommandRequest,
    command_line,
    command_places,
    file_choices,
    forms,
)
from dampyr.errors import InputError, MissingData

ONE, TWO, THREE = (f"data/tests/test {k}.h5" for k in (1, 3, 5))
# Each command with values that are not the usual ones, and what its answer holds.
REQUESTS = {
    "records": ({"paths": [ONE, TWO], "role": "fit"}, "2 records"),
    "records convert": ({"paths": [ONE], "to": "csv", "out": "csv"}, "1 record in csv"),
    "cycles": ({"paths": [ONE], "speeds": ["50"], "unit_system": "in-lb"}, "Whole records"),
    "accept": (
        {"reference": "cards/damper.toml", "paths": [ONE], "tolerance": "20%", "quantities": ["energy"]},
        "± 20 %",
    ),
    "protocol": ({"folder": "response", "limits": "limits.csv"}, "response_time: passed"),
    "judge": ({"folders": ["specimen-17"], "criteria": "ntc_2018_viscous", "design": "design.toml"}, "1 passed"),
    "specimens": ({"folders": ["specimen-17"]}, "Specimens"),
    "identify": (
        {"paths": [ONE, TWO, THREE], "model": "dahl", "laws": ["dahl.kx=constant"], "save": "card.toml"},
        "dahl, 3 records",
    ),
    "posterior": ({"paths": [ONE, TWO, THREE], "model": "dahl", "lengths": "3", "tails": "normal"}, "97.5 %"),
    "validate": ({"card": "cards/damper.toml", "paths": ["data/tests/test 7.h5"], "settling": "0.5"}, "Mean L1"),
    "plan": ({"card": "cards/damper.toml", "tests": "2", "rig": "lab", "out": "next.toml"}, "2 tests"),
    "export": ({"card": "cards/damper.toml", "kind": "c", "name": "mine"}, "mine.h"),
    "simulate": (
        {
            "card": "cards/damper.toml", "voltages": ["1"], "motion": "motions/kobe.csv", "motion_unit": "g",
            "dt": "0.02", "between": ["0", "2"],
        },
        "kobe",
    ),
    "ensemble": (
        {"card": "cards/damper.toml", "voltages": ["1"], "synthetic": "3", "duration": "4", "scales": ["0.5,1"]},
        "6 cases",
    ),
    "arena": (
        {"card": "cards/damper.toml", "voltages": ["1"], "controls": ["on_off"], "synthetic": "3", "duration": "4"},
        "3 cases of each input",
    ),
    "ride": ({"card": "cards/damper.toml", "voltages": ["1"], "seeds": "1", "length": "50"}, "1 road"),
    "motion": ({"file": "motions/HNE.asc", "pga": "0.3g", "periods": ["0.5"]}, "Response spectrum"),
    "hybrid": ({"delay": "0.01", "model": "cards/damper.toml", "voltage": "1", "duration": "2"}, "Virtual hybrid test"),
    "reproduce": ({"study": "quarter_car_2025"}, "off by"),
    "datasets list": ({}, "labcontrol"),
    "datasets show": ({"name": "quiroz_2022"}, "quiroz_2022"),
    "calibrate": ({"rig": "lab", "seconds": "0.2"}, "calibration.toml"),
    "doctor": ({"simulated": True}, "numpy"),
    "demo": ({}, "Held-out tests"),
    "licences": ({"extras": ["fmu"]}, "numpy"),
}  # fmt: skip


def fill(data: Path) -> None:
    """The files that the requests name."""
    fill_example_folder(data)
    shutil.rmtree(data / "lab")
    for name, place in {
        "damper.toml": "cards/damper.toml", "rig.toml": "rigs/lab/rig.toml", "kobe.csv": "motions/kobe.csv",
        "campaign.toml": "campaigns/campaign.toml",
    }.items():  # fmt: skip
        (data / place).parent.mkdir(parents=True, exist_ok=True)
        (data / name).rename(data / place)


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("commands") / "data"
    folder.mkdir()
    fill(folder)
    return folder


def typed(data: Path, command: str, **values: object) -> list[str]:
    return command_line(CommandRequest(command=command, values=values), data, ".console/jobs/x").typed


def test_every_command_is_on_a_page_or_says_why_not() -> None:
    told = {command: (page, why) for command, page, why in command_places()}
    assert set(told) == set(command_forms())
    assert all(page or why for page, why in told.values())
    assert set(NOT_OFFERED) | set(forms()) == set(told)
    assert not set(NOT_OFFERED) & set(forms())
    assert sum(map(len, GROUPS.values())) == len(forms())
    assert set(PAGES) <= set(told)


def test_every_parameter_is_of_a_form() -> None:
    """What stands in the tables of this module is a parameter of its command; files are chosen and never typed."""
    from dampyr.console import command_words as tables

    described = command_forms()
    names = {command: {p["name"] for p in form["parameters"]} for command, form in described.items()}
    for table in (tables.LEFT_OUT, tables.NEEDS_ONE_OF):
        for command, parameters in table.items():
            assert set(parameters) <= names[command], command
    assert all(name in names[command] for command, name in (*tables.TEXT, *tables.DAMPERS))
    for command, form in forms().items():
        for parameter in form["parameters"]:
            named = parameter["name"] in (*tables.KIND_OF_FILE, *tables.WRITTEN)
            assert not parameter["is_file"] or named, f"{command}: {parameter['name']} names a file: of which kind?"
            assert parameter["label"], command


@pytest.mark.parametrize("command", [name for name in REQUESTS if name != "demo"])
def test_a_request_is_words_that_the_command_line_takes(command: str, filled: Path) -> None:
    """They are parsed by click, with every value that is asked for, and nothing leads out of the data folder."""
    values, _ = REQUESTS[command]
    request = CommandRequest(command=command, values=values)
    words = command_line(request, filled, ".console/jobs/x")
    with cli.make_context("dampyr", []) as root:
        member = cli.get_command(root, words.typed[0])
        assert member is not None
        rest = words.typed[1:]
        if isinstance(member, click.Group):
            member, rest = member.commands[rest[0]], rest[1:]
        context = member.make_context(command, list(rest), parent=root)
    shown = str(context.params)
    for name, value in values.items():
        for one in [value] if isinstance(value, str) else value if isinstance(value, list) else []:
            text = {"rig": f"rigs/{one}/rig.toml"}.get(name, one.removeprefix("data/"))
            assert text in shown or float(text) in context.params[name] or context.params[name] == float(text), name
    assert all(not word.startswith(("/", "..")) for word in words.run)


def test_every_offered_command_has_a_request() -> None:
    assert set(REQUESTS) == set(forms())


@pytest.mark.parametrize(
    ("command", "values", "words"),
    [
        ("simulate", {"structure": "/etc/passwd"}, "is not a valid file name"),
        ("simulate", {"structure": "structures/../../x.toml"}, "is not a valid file name"),
        ("simulate", {"structure": "structures/none.toml"}, "is not in the data folder"),
        ("simulate", {"motion": "../quake.csv"}, "is not a valid file name"),
        ("simulate", {"card": "nothing"}, "neither a card nor a published damper"),
        ("simulate", {"controls": ["/tmp/mine.py"]}, "outside of the data folder"),
        ("simulate", {"controls": ["mine.py:gain=1"]}, "outside of the data folder"),
        ("motion", {"design": "file=../../secret.csv"}, "outside of the data folder"),
        ("motion", {"save": "../x.txt"}, "is not a file name"),
        ("motion", {"scale": "x"}, "is not a valid float"),
        ("motion", {"save": "x\ny"}, "is not a file name"),
        ("motion", {"nothing": "1"}, "has no 'nothing' here"),
        ("motion", {"baseline": "yes"}, "ticked or not"),
        ("motion", {"scale": True}, "is a text"),
        ("motion", {"scale": ["1", "2"]}, "takes one value and not 2"),
        ("motion", {"scale": "--report=/tmp/x"}, "begins with -"),
        ("motion", {"scale": "1" * 700}, "at most 640"),
        ("motion", {"report": "/tmp/x.html"}, "has no 'report' here"),
        ("simulate", {"between": ["0"]}, "takes 2 values"),
        ("accept", {"paths": [ONE], "reference": "cards/damper.toml", "tolerance": "2"}, "at most 1"),
        ("hybrid", {"voltage": "1"}, "Delay or Record is missing"),
        ("identify", {"model": "dahl"}, "Records is missing"),
        ("calibrate", {"rig": "other"}, "is not known"),
        ("run", {}, "is not offered here"),
        ("serve", {}, "is not offered here"),
        ("datasets fetch", {"name": "labcontrol"}, "is not offered here"),
        ("simulat", {}, "there is no command 'simulat'"),
    ],
)
def test_a_wrong_request_is_refused_before_it_is_a_job(
    command: str, values: dict[str, object], words: str, filled: Path
) -> None:
    with pytest.raises((InputError, MissingData), match=words):
        typed(filled, command, **values)


def test_links_are_not_followed(filled: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere.toml").write_text("x = 1\n")
    link = filled / "structures"
    link.mkdir(exist_ok=True)
    (link / "link.toml").symlink_to(tmp_path / "elsewhere.toml")
    with pytest.raises(InputError, match="is a link"):
        typed(filled, "simulate", structure="structures/link.toml")
    assert "structures/link.toml" not in {one["value"] for one in file_choices(filled)["structures"]}
    (link / "link.toml").unlink()


def test_a_negative_number_is_a_value(filled: Path) -> None:
    assert "--scale=-1.5" in typed(filled, "motion", scale="-1.5")


def test_what_can_be_chosen_is_what_is_there(filled: Path) -> None:
    listed = {kind: {one["value"] for one in choices} for kind, choices in file_choices(filled).items()}
    assert "cards/damper.toml" in listed["dampers"]
    assert {"specimen-17", "tests", "response"} <= listed["folders"]
    assert "motions/kobe.csv" in listed["motions"]
    assert "quarter_car_2025" in listed["studies"]
    assert "ntc_2018_viscous" in listed["criteria"]
    assert listed["rigs"] == {"lab"}


def test_a_job_tells_tables_and_has_its_files(client, data, finished) -> None:
    """Through the API: a command with a page and figures, one that writes a file, one that fails, and foreign files."""
    fill(data)
    ids = {}
    for command in ("motion", "records convert"):
        answer = client.post("/api/commands/jobs", json={"command": command, "values": REQUESTS[command][0]})
        assert answer.status_code == 202, answer.text
        ids[command] = answer.json()["id"]
    motion = finished(ids["motion"])
    assert motion["state"] == "done", motion
    tables = [one["table"] for one in motion["result"]["output"] if "table" in one]
    assert [table["caption"] for table in tables][1:] == ["Response spectrum"]
    assert len(tables[1]["rows"]) == 1
    assert motion["result"]["page"]
    assert motion["result"]["command"].startswith("dampyr motion")
    page = client.get(f"/api/commands/jobs/{ids['motion']}/page")
    assert page.status_code == 200
    assert "dampyr motion" in page.text
    name = motion["result"]["figures"][0]
    figure = client.get(f"/api/commands/jobs/{ids['motion']}/figure", params={"name": name})
    assert figure.headers["content-type"].startswith("image/svg+xml")
    assert client.get(f"/api/commands/jobs/{ids['motion']}/figures").content[:2] == b"PK"
    written = finished(ids["records convert"])["result"]
    assert written["files"] == ["csv/test 1.csv"]
    assert written["output"] == [{"text": "1 record in csv"}]
    file = client.get(f"/api/commands/jobs/{ids['records convert']}/file", params={"name": "csv/test 1.csv"})
    assert "force" in file.text.splitlines()[0]
    for name in ("../request.json", "../../../../cards/damper.toml", "/etc/passwd", "nothing"):
        answer = client.get(f"/api/commands/jobs/{ids['records convert']}/file", params={"name": name})
        assert answer.status_code in (400, 404), name
    refused = client.post("/api/commands/jobs", json={"command": "validate", "values": {"card": "cards/damper.toml"}})
    assert refused.status_code == 400
    assert "Records is missing" in refused.json()["detail"]


def files_of(data: Path) -> set[Path]:
    """The files of the data folder but for the console's own."""
    return {path.relative_to(data) for path in data.rglob("*") if ".console" not in path.parts}


def check_result(command: str, result: dict[str, object], data: Path) -> None:
    """It tells what it is asked for, has the page and the figures that the command makes, and names no place of the machine."""
    output, makes = str(result["output"]), forms()[command]["makes"]
    assert REQUESTS[command][1] in output, output
    assert result["page"] == ("report" in makes)
    assert bool(result["figures"]) <= bool({"figures", "figure"} & set(makes))
    assert str(data.parent) not in output or command == "doctor"


@pytest.mark.prove
def test_the_demonstration_leaves_its_files_in_the_job(tmp_path: Path, monkeypatch, data_root) -> None:
    """The one command that takes too long for a browser: test_commands_in_a_browser performs all others."""
    from dampyr.console.jobs import command as job

    monkeypatch.setenv("DAMPYR_DATA", str(data_root))
    data = tmp_path / "data"
    data.mkdir()
    fill(data)
    folder = data / ".console" / "jobs" / "0123456789abcdef"
    folder.mkdir(parents=True)
    before = files_of(data)
    check_result("demo", job.run({"command": "demo", "values": {}}, folder, lambda stage, done: None), data)
    assert files_of(data) == before
    assert (folder / FILES / "report.html").is_file()
