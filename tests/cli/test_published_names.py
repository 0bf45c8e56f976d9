"""A published damper's name wherever a card goes, and what is said where there is neither."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from tests.identification.synthetic import sine

from dampyr.cli import cli
from dampyr.errors import MissingData
from dampyr.models import published
from dampyr.records import write
from dampyr.rig import RigSettings, diagnosis
from dampyr.rig.settings import SpecimenSettings
from dampyr.rig.specimen import specimen_of
from dampyr.studies import load_damper, raminelli_2020

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def missing(name: str) -> str:
    raise diagnosis.metadata.PackageNotFoundError(name)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(each) for each in arguments], catch_exceptions=False)


def test_simulate_and_ensemble_take_a_name(tmp_path: Path) -> None:
    card = raminelli_2020.damper().save(tmp_path / "card.toml")
    for command in (("simulate", "--voltage", "1.98"), ("ensemble", "--voltage", "1.98", "--scale", "0.5,1")):
        named, loaded = (run(*command, damper, "--json") for damper in ("raminelli_2020", card))
        assert named.exit_code == 0, named.output
        assert json.loads(named.stdout) == json.loads(loaded.stdout)


def test_validate_and_export_take_a_name(tmp_path: Path) -> None:
    record = tmp_path / "record.h5"
    write(sine(raminelli_2020.damper(), 1.98, "test"), record)
    scored = run("validate", "raminelli_2020", record, "--json")
    assert json.loads(scored.stdout)["scores"]["test"]["l1"] < 1e-6
    assert run("export", "spencer_1997", "--without", "lag", "--to", "c", "--out", tmp_path).exit_code == 0
    assert (tmp_path / "damper.c").is_file()


@pytest.mark.prove
def test_the_specimen_of_a_rig_takes_a_name(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('[specimen]\ncard = "spencer_1997"\n', "utf-8")
    done = run("run", EXAMPLES / "quick_campaign.toml", "--dry-run", "--rig", tmp_path / "rig.toml")
    assert "quick: 3 tests" in done.stdout, done.output
    settings = replace(RigSettings(), specimen=SpecimenSettings(card="spencer_1997"))
    assert specimen_of(settings, tmp_path).all_laws == published.damper("spencer_1997").all_laws


@pytest.mark.parametrize(
    "command",
    [
        ("simulate", "spenser_1997", "--voltage", "1"),
        ("ensemble", "spenser_1997", "--voltage", "1"),
        ("validate", "spenser_1997", "record.h5"),
        ("export", "spenser_1997", "--to", "c"),
    ],
)
def test_what_is_neither_is_told_with_the_names_and_the_files(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    raminelli_2020.damper().save("ours.toml")
    refused = run(*command)
    assert refused.exit_code == 2
    assert "spenser_1997: there is no such card, and no published damper of this name; did you mean" in refused.stderr
    assert "'spencer_1997'" in refused.stderr
    assert "there is ours.toml, published are " in refused.stderr
    assert all(name in refused.stderr for name in ("raminelli_2020", *published.available_sets()))


def test_a_file_of_the_same_name_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    raminelli_2020.damper().save("spencer_1997")
    assert load_damper("spencer_1997").parts == ("dahl",)
    with pytest.raises(MissingData, match=r"no\.toml: there is no such card"):
        load_damper("no.toml")


def test_the_doctor_says_how_to_install_what_a_rig_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis.metadata, "version", missing)
    assert {finding.repair for finding in diagnosis.diagnose()[:3]} == {'pip install "dampyr[rig]"'}
