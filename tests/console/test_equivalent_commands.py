"""The command that a report of the console names is one that the command line takes."""

import shlex

import click
import pytest

pytest.importorskip("fastapi")

from dampyr.cli import cli
from dampyr.cli._options import OptionsCommand
from dampyr.console.building_schemas import EnsembleRequest, MotionRequest, ResponseRequest
from dampyr.console.equivalent_commands import (
    WHERE,
    accept_command,
    ensemble_command,
    identify_command,
    response_command,
    validate_command,
)
from dampyr.console.identify_schemas import IdentifyRequest, ValidateRequest
from dampyr.console.record_acceptance import AcceptanceRequest
from dampyr.identification import AcceptOptions, FitOptions, ScoreOptions
from dampyr.structures import EnsembleOptions, RespondOptions

KEYS = ["data/uploads/a test.h5", "labcontrol/ensaio.A.1.mat"]


def parsed(text: str) -> dict[str, object]:
    """What click makes of the words; an unknown option or a wrong value is an error."""
    command, _, note = text.rpartition(" (")
    assert note.startswith(WHERE)
    program, name, *words = shlex.split(command)
    assert program == "dampyr"
    with cli.make_context("dampyr", []) as root:
        member = cli.get_command(root, name)
        assert member is not None
        context: click.Context = member.make_context(name, words, parent=root)
        chosen = member.chosen(context.params) if isinstance(member, OptionsCommand) else {}
        return {"command": name, **context.params, **chosen}


def test_identification() -> None:
    request = IdentifyRequest(records=KEYS, model="dahl + spring", predict=["record"], loss="huber", settling=3.0)
    given = parsed(identify_command(request))
    assert (given["command"], given["model"]) == ("identify", "dahl + spring")
    assert [str(path) for path in given["paths"]] == ["uploads/a test.h5", "labcontrol/ensaio.A.1.mat"]
    assert given["options"] == FitOptions(predict=("record",), loss="huber", settling=3.0)
    tried = parsed(identify_command(IdentifyRequest(records=KEYS, models=["dahl", "bingham"])))
    assert (tried["model"], tried["options"]) == (None, FitOptions(models=("dahl", "bingham")))


def test_validation_and_acceptance() -> None:
    given = parsed(validate_command(ValidateRequest(records=KEYS, card="cards/x.toml", allow_extrapolation=True)))
    assert (str(given["card"]), given["options"]) == ("cards/x.toml", ScoreOptions(allow_extrapolation=True))
    for band in (0.5, None):
        given = parsed(validate_command(ValidateRequest(records=KEYS, card="cards/x.toml", band=band)))
        assert given["options"] == ScoreOptions(band=band)
    request = AcceptanceRequest(
        key=KEYS, reference=["cards/x.toml"], tolerance=0.1, force_slack=20, quantities=["energy"], offset=-5, relevel=2
    )
    given = parsed(accept_command(request))
    assert (given["reference"], given["options"]) == (
        "cards/x.toml",
        AcceptOptions(0.1, force_slack=20.0, quantities=("energy",), offset=-5.0, relevel=2),
    )
    assert "a folder of these records" in accept_command(request.model_copy(update={"reference": KEYS}))


def test_buildings() -> None:
    given = parsed(response_command(ResponseRequest(after=2.0, accuracy=1e-5, without=["delay"])))
    assert (given["command"], given["voltages"]) == ("simulate", (0.0, 1.98))
    assert given["options"] == RespondOptions(after=2.0, accuracy=1e-5, without=("delay",))
    given = parsed(ensemble_command(EnsembleRequest(motion=MotionRequest(kind="kanai_tajimi", pga=2.5), seed=7)))
    assert (given["synthetic"], given["pga"]) == (20, "2.5m/s^2")
    assert (given["scales"], given["without_damper"]) == (("0.5,1,1.5,2,2.5,3",), True)
    assert given["options"] == EnsembleOptions(limits=("12mm",), seed=7)
    given = parsed(ensemble_command(EnsembleRequest(precision=32, limits=["1%", "0.5g"], height=3.0)))
    assert given["options"] == EnsembleOptions(precision=32, limits=("1%", "0.5g"), height=3.0)
    motion = MotionRequest(kind="file", file="a.at2", unit="g")
    assert str(parsed(response_command(ResponseRequest(motion=motion)))["motion"]) == "motions/a.at2"
    assert "synthetic motion of 20 s, seed 3" in response_command(
        ResponseRequest(motion=MotionRequest(kind="kanai_tajimi", seed=3))
    )
    shear = ResponseRequest(building={"kind": "shear", "masses": [1.0], "stiffnesses": [1.0]})
    assert "a shear building of 1 storeys" in response_command(shear)
    given = parsed(response_command(ResponseRequest(building={"kind": "published", "name": "ohtori_2004"})))
    assert given["structure"] == "ohtori_2004"
    given = parsed(ensemble_command(EnsembleRequest(building={"kind": "file", "name": "mine.toml"})))
    assert given["structure"] == "structures/mine.toml"
