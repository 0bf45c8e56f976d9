"""The frame of the command line: quick help, one line for what is wrong, exit code 2."""

import importlib
import json
import subprocess
import sys
import warnings
from collections.abc import Callable
from types import ModuleType

import click
import pytest
from click.testing import CliRunner, Result
from tests.cli.broken_stream import Broken

from dampyr import registry
from dampyr.cli import _frame, cli
from dampyr.errors import DampyrWarning, FileError, MissingData, RangeError
from dampyr.source_digest import full_version

Invoke = Callable[..., Result]
COMMANDS = registry.names("dampyr.cli")


def run(*args: str) -> Result:
    """A command as a person would run it; an exception that shows a traceback fails the test."""
    return CliRunner().invoke(cli, list(args), catch_exceptions=False)


@pytest.fixture
def plant(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], object]], None]:
    """Put a command called ``planted-command`` on the shelf that calls a function."""

    def put(body: Callable[[], object]) -> None:
        module = ModuleType("dampyr.cli.planted_command")
        module.command = click.command(help="Do what was planted.")(body)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(registry, "names", lambda group: [*COMMANDS, "planted_command"])
        importlib.invalidate_caches()

    return put


def test_help_lists_every_command_with_one_line() -> None:
    shown = run("--help").output
    for name in COMMANDS:
        words = next(line for line in shown.splitlines() if line.strip().startswith(name.replace("_", "-")))
        assert len(words.split()) > 2
        assert "..." not in words
    assert run().output == shown
    assert run("-h").output == shown


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself_and_speaks_json(name: str) -> None:
    command = registry.member("dampyr.cli", name).command
    leaves = command.commands.values() if isinstance(command, click.Group) else [command]
    for leaf in leaves:
        assert leaf.help
        assert "--json" in {option for param in leaf.params for option in param.opts}, leaf.name
    assert run(name.replace("_", "-"), "--help").exit_code == 0


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys, json\nfrom dampyr.cli import main\nsys.argv = ['dampyr', '--help']\n"
        "try:\n    main()\nexcept SystemExit as end:\n    print('\\n' + json.dumps([end.code, *sys.modules]))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    exit_code, *loaded = json.loads(out.splitlines()[-1])
    assert exit_code == 0
    assert not {"numpy", "scipy", "numba", "matplotlib", "xarray", "rich", "pint"} & set(loaded)


def test_version() -> None:
    assert run("--version").output == f"dampyr {full_version()}\n"


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (FileError("a.csv", "column 2\nhas no unit"), "dampyr: a.csv: column 2 has no unit"),
        (RangeError("voltage = 9 V is too high"), "dampyr: voltage = 9 V is too high"),
        (MissingData("fetch it"), "dampyr: fetch it"),
        (
            FileNotFoundError(2, "No such file or directory", "b.toml"),
            "dampyr: b.toml: No such file or directory",
        ),
        (PermissionError(13, "Permission denied", "out"), "dampyr: out: Permission denied"),
        (click.BadParameter("too bad"), "dampyr: Invalid value: too bad"),
    ],
)
def test_what_is_wrong_is_one_line_and_exit_code_2(plant: Invoke, error: Exception, line: str) -> None:
    def body() -> None:
        raise error

    plant(body)
    result = run("planted-command")
    assert result.exit_code == 2
    assert result.stderr.splitlines()[0].startswith(line)
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""


def test_a_fault_of_ours_keeps_its_traceback(plant: Invoke) -> None:
    def body() -> None:
        raise ZeroDivisionError("a fault")

    plant(body)
    with pytest.raises(ZeroDivisionError, match="a fault"):
        run("planted-command")


def test_an_interruption_is_no_traceback(plant: Invoke) -> None:
    def body() -> None:
        raise KeyboardInterrupt

    plant(body)
    result = run("planted-command")
    assert result.exit_code == 130
    assert result.stderr.strip() == "dampyr: interrupted"


def test_a_command_may_give_an_exit_code(plant: Invoke) -> None:
    plant(lambda: 3)
    assert run("planted-command").exit_code == 3
    plant(lambda: None)
    assert run("planted-command").exit_code == 0


def test_our_warnings_are_one_line_each_and_once(plant: Invoke) -> None:
    def body() -> None:
        for _ in range(2):
            warnings.warn("voltage 3.6 V is above\n3.212 V", DampyrWarning, stacklevel=1)

    plant(body)
    result = run("planted-command")
    assert result.exit_code == 0
    assert result.stderr == "dampyr: warning: voltage 3.6 V is above 3.212 V\n"


def test_other_warnings_are_left_alone(plant: Invoke) -> None:
    def body() -> None:
        warnings.warn("of a library", RuntimeWarning, stacklevel=1)

    plant(body)
    with pytest.raises(RuntimeWarning, match="of a library"):  # the tests make errors of warnings
        run("planted-command")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["recrods"], "there is no command 'recrods'; did you mean 'records'? choose from "),
        (["_frame"], "there is no command '_frame'; "),
        (["--colour"], "No such option"),
        (["records", "--jsno"], "No such option"),
        (["records", "--role", "best"], "Invalid value for '--role'"),
    ],
)
def test_a_slip_of_the_pen_is_one_line(args: list[str], words: str) -> None:
    result = run(*args)
    assert result.exit_code == 2
    assert result.stderr.startswith("dampyr: ")
    assert words in result.stderr
    assert "--help`" in result.stderr
    assert result.stderr.count("\n") == 1


def test_as_a_process() -> None:
    command = [sys.executable, "-m", "dampyr", "records", "no-such-file.csv"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr.startswith("dampyr: no-such-file.csv: ")
    assert result.stderr.count("\n") == 1


def test_a_warning_that_cannot_be_shown_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Broken(BrokenPipeError(32, "Broken pipe"), 0, False))
    with _frame._warnings_in_one_line():
        warnings.warn("the journal was lost", DampyrWarning, stacklevel=1)
