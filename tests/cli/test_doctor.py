"""``dampyr doctor`` tells what is there, and what is not."""

import json
import platform
import shutil
from importlib import metadata
from pathlib import Path

import pytest
from click.testing import CliRunner

from dampyr import kernel_warming
from dampyr.cli import cli


def findings() -> dict[str, dict[str, str | None]]:
    result = CliRunner().invoke(cli, ["doctor", "--json"], catch_exceptions=False)
    assert result.exit_code == 0, result.stderr
    return {each["what"]: each for each in json.loads(result.stdout)}


def test_it_tells_what_is_there() -> None:
    by_name = findings()
    assert by_name["Python"]["found"] == platform.python_version()
    assert by_name["numba"]["found"] == metadata.version("numba")
    assert Path(str(by_name["compiled kernels"]["found"])).is_dir()


def test_it_tells_what_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    monkeypatch.setattr(shutil, "which", lambda name: None)
    by_name = findings()
    assert by_name["data set labcontrol"]["found"] == "absent"
    assert by_name["data set labcontrol"]["repair"] == "dampyr datasets fetch labcontrol"
    assert by_name["C compiler"]["found"] == "none"
    assert "gcc" in str(by_name["C compiler"]["repair"])


def test_people_get_a_table() -> None:
    shown = CliRunner().invoke(cli, ["doctor"], catch_exceptions=False).stdout
    assert shown.startswith("dampyr ")
    assert "numpy" in shown


def test_a_simulated_rig_is_brought_up_by_a_stand_in_and_a_fault_ends_it(tmp_path: Path) -> None:
    words = ["doctor", "--simulated", "--bring-up", "--stand-in", "--json", "--out", str(tmp_path / "b.json")]
    failed = CliRunner().invoke(cli, [*words, "--fault", "inverted-cell@0s"])
    assert failed.exit_code == 3
    assert [row["verdict"] for row in json.loads(failed.stdout)] == ["passed", "passed", "passed", "failed"]
    whole = CliRunner().invoke(cli, words)
    assert whole.exit_code == 0
    assert {row["verdict"] for row in json.loads(whole.stdout)} == {"passed", "not wired"}


def test_a_person_reads_what_to_do_is_asked_and_may_end_it(tmp_path: Path) -> None:
    words = ["doctor", "--simulated", "--bring-up", "--out", str(tmp_path / "b.json")]
    result = CliRunner().invoke(cli, words, input="y\nq\n")
    assert result.exit_code == 130
    assert "Do: connect the Uno by its USB cable only" in result.stderr
    assert "must be 1000" in result.stderr
    assert [row["verdict"] for row in json.loads((tmp_path / "b.json").read_text())["steps"]] == ["passed"]


def test_an_energised_step_says_so_before_it_asks(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from dampyr.cli._bring_up import TerminalOperator
    from dampyr.rig.bring_up import STEPS

    monkeypatch.setattr("click.prompt", lambda *_, **__: "s")
    for step in STEPS:
        assert TerminalOperator().begin(step) == "skip"
        assert ("ENERGISES" in capsys.readouterr().err) is step.energised


@pytest.mark.parametrize("words", [["--bring-up"], ["--stand-in"], ["--rig", "r.toml", "--bring-up", "--stand-in"]])
def test_options_of_a_bring_up_that_do_not_fit_are_refused(words: list[str]) -> None:
    result = CliRunner().invoke(cli, ["doctor", *words])
    assert result.exit_code == 2
    assert "--bring-up" in result.stderr or "--stand-in" in result.stderr


@pytest.mark.parametrize("words", [["--simulated"], ["--rig", "rig.toml"], ["--bring-up"], ["--fault", "encoder_jump"]])
def test_warming_goes_alone(words: list[str]) -> None:
    result = CliRunner().invoke(cli, ["doctor", "--warm", *words])
    assert result.exit_code == 2
    assert "--warm looks at no rig" in result.stderr


def test_what_was_warmed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    outcomes = [
        kernel_warming.WarmedKernels(59, 59, 97.4, Path("kernels")),
        kernel_warming.WarmedKernels(59, 0, 0.1, Path("kernels")),
    ]
    monkeypatch.setattr(kernel_warming, "warm_kernels", lambda progress: outcomes.pop(0))
    first = CliRunner().invoke(cli, ["doctor", "--warm"], catch_exceptions=False).stdout
    assert first == "59 kernels of the usual commands, compiled 59, 97.4 s: kernels\n"
    again = json.loads(CliRunner().invoke(cli, ["doctor", "--warm", "--json"], catch_exceptions=False).stdout)
    assert again == {"kernels": 59, "compiled": 0, "seconds": 0.1, "folder": "kernels"}
