"""Arguments of the public calls: every path is a text or a Path, and what is swapped or of another kind is one sentence."""

import inspect
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import InputError, MissingData
from dampyr.identification.scoring.score import prediction

RESULTS = {"CampaignRow", "Planned", "RecordedCampaign", "Round", "Rig"}  # what calls return: their fields hold paths


def public_calls() -> Iterator[tuple[str, Callable[..., Any]]]:
    for package in dp._PACKAGES:
        module = import_module(f"dampyr.{package}")
        for name in getattr(module, "__all__", ()):
            one = getattr(module, name)
            if inspect.isclass(one):
                if name not in RESULTS:
                    yield f"{package}.{name}", one
                methods = vars(one).items()
                yield from ((f"{package}.{name}.{k}", v) for k, v in methods if k[0] != "_" and inspect.isfunction(v))
            elif callable(one):
                yield f"{package}.{name}", one


def test_every_path_argument_takes_a_text() -> None:
    wrong = []
    for name, call in public_calls():
        try:
            parameters = inspect.signature(call).parameters.values()
        except (TypeError, ValueError):
            continue
        for each in parameters:
            kinds = {kind.strip() for kind in str(each.annotation).split("|")}
            if kinds & {"Path", "<class 'pathlib.Path'>"} and "str" not in kinds:
                wrong.append(f"{name}({each.name}: {each.annotation})")
    assert wrong == []


def damper() -> Any:
    return dp.studies.raminelli_2020.damper()


def record() -> Any:
    t = np.linspace(0.0, 4.0, 401)
    x = 0.008 * np.sin(2 * np.pi * t)
    return dp.records.Record(t, x, damper().force(t, x, voltage=1.98), voltage=1.98, name="sine")


BUILDING, MOTION = dp.structures.two_storey(), dp.ground_motions.el_centro()
ID, S = dp.identification, dp.structures
CALLS: dict[str, tuple[Callable[[], Any], str]] = {
    "fit of an array": (lambda: ID.fit(np.zeros(9), "dahl"), r"fit\(records, model\): records is of the type ndarray; give"),
    "fit of records and a file": (lambda: ID.fit([record(), "b.csv"], "dahl"), "records is a list that holds"),
    "fit of a path": (lambda: ID.fit(Path("lab"), "dahl"), "lab: there is no such file or folder; check the path"),
    "fit in its old order": (lambda: ID.fit("dahl", [record()]), r"first since 0.4.0; write fit\(records, model\)"),
    "fit of a damper to one record": (lambda: ID.fit(damper(), record()), r"records come first since 0.4.0"),
    "fit of a number": (lambda: ID.fit([record()], 3), "model is of the type int; give the name of a model"),
    "fit without a model": (lambda: ID.fit("lab"), "lab: there is no such file or folder; check the path"),
    "fit with a wrong word": (lambda: ID.fit(record(), "dahl", los="l1"), r"los=\) is not known; did you mean 'loss'"),
    "fit with other options": (lambda: ID.fit(record(), "dahl", ID.ScoreOptions()), "of the type ScoreOptions; give"),
    "fit_specimens": (lambda: ID.fit_specimens("dahl", [record()]), r"records come first .* fit_specimens\(records, model\)"),
    "score swapped": (lambda: ID.score(record(), damper()), r"arguments of score are swapped; write score\(damper, record\)"),
    "score of a file": (lambda: ID.score(damper(), "a.csv"), r"record is the text 'a.csv'; give a Record"),
    "score by a card's name": (lambda: ID.score("card.toml", record()), r"damper is the text 'card.toml'; give a Damper"),
    "prediction": (lambda: prediction(record(), damper()), "arguments of prediction are swapped"),
    "prediction_band": (lambda: ID.prediction_band(record(), damper()), "arguments of prediction_band are swapped"),
    "validate": (lambda: ID.validate([record()], damper()), "arguments of validate are swapped"),
    "accept": (lambda: ID.accept(damper(), record()), r"arguments of accept are swapped; write accept\(records, reference\)"),
    "accept of files' names": (lambda: ID.accept(["a.csv"], damper()), "a.csv: there is no such file; check"),
    "cycles of a number": (lambda: dp.records.cycles(3), r"cycles\(records\): records is of the type int; give records"),
    "respond to an array": (lambda: S.respond(BUILDING, np.zeros(9)), r"motion is of the type ndarray; give a GroundMotion"),
    "respond swapped": (lambda: S.respond(MOTION, BUILDING), r"swapped; write respond\(building, motion\)"),
    "respond to a file": (lambda: S.respond(BUILDING, "elcentro.dat"), "motion is the text 'elcentro.dat'"),
    "ensemble of arrays": (lambda: S.ensemble(BUILDING, np.zeros(9)), "motions"),
    "a page of another choice": (lambda: dp.show.write_page(MOTION, "x.html", title=""), "no such choice; it has damp"),
    "export swapped": (lambda: dp.export.export("c", damper(), "out"), r"swapped; write export\(damper, to\)"),
    "export of a card's name": (lambda: dp.export.export("card.toml", "c", "out"), "damper is the text 'card.toml'"),
}  # fmt: skip


@pytest.mark.parametrize("what", CALLS)
def test_an_argument_of_another_kind_is_one_sentence(what: str) -> None:
    call, sentence = CALLS[what]
    with pytest.raises((InputError, MissingData), match=sentence) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_damper_of_numbers_holds_at_every_input(tmp_path: Path) -> None:
    """And needs none: along a path, in a building, in an ensemble, in its card and in what is exported."""
    numbers = {"dahl.kx": 1000.0, "dahl.kw": 200.0, "dahl.rho": 1000.0}
    passive = dp.models.Damper("dahl", numbers)
    t = np.linspace(0.0, 2.0, 401)
    x = 0.008 * np.sin(2 * np.pi * t)
    force = passive.force(t, x)
    assert np.array_equal(force, passive.force(t, x, voltage=12.0))
    assert np.array_equal(force, passive.force(t, x, current=np.linspace(0.0, 1.0, t.size)))
    alone = S.respond(BUILDING, MOTION, passive)
    assert np.array_equal(alone.peak_displacement, S.respond(BUILDING, MOTION, passive, voltage=3.0).peak_displacement)
    peaks = S.ensemble(BUILDING, MOTION, passive).dataset.displacement.values.ravel()
    np.testing.assert_allclose(peaks, alone.peak_displacement, rtol=1e-3)
    again = dp.models.Damper.load(passive.save(tmp_path / "card.toml"))
    assert not again.needs_input
    assert np.array_equal(again.force(t, x), force)
    [_, source, *_] = dp.export.export(again, "c", str(tmp_path / "c"))
    assert "return isfinite(u);" in source.read_text("utf-8")
    assert "holds at every input" in repr(passive)


def test_a_damper_with_one_law_still_needs_its_input() -> None:
    law = dp.models.Polynomial((50.0, 190.0), 0.0, 2.5)
    mixed = dp.models.Damper("dahl", {"dahl.kx": 1000.0, "dahl.kw": law, "dahl.rho": 1000.0})
    assert mixed.needs_input
    assert mixed.range == (0.0, 2.5)
    with pytest.raises(InputError, match="needs its voltage"):
        mixed.force([0.0, 0.1], [0.0, 1e-3])


def test_a_fit_saves_its_card(tmp_path: Path) -> None:
    fit = ID.fit(record(), "dahl")
    path = fit.save(str(tmp_path / "card.toml"))
    assert dp.models.Damper.load(path).laws == fit.damper.laws
