"""Every kind of finding, planted in a record: what is made of the record says it once, to the building and the export."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.findings import OF_DAMPER, handed_on
from dampyr.ground_motions import el_centro
from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.records import Record, repair, with_smoothing, write
from dampyr.records.checks.certificates import Certificates, RelativeCertificate
from dampyr.records.conditioning.integrated_displacement import INTEGRATED
from dampyr.records.description import findings_by_kind
from dampyr.records.record import Label
from dampyr.structures import respond, two_storey
from tests.records.test_smoothing_recognition import smoothed
from tests.stories.figure_texts import texts_alone

DAHL = Damper("dahl", {"dahl.kx": 1200.0, "dahl.kw": 200.0, "dahl.rho": 2000.0})
T = np.arange(0.0, 8.0, 0.005)


def of_motion(x: np.ndarray, t: np.ndarray = T, noise: float = 0.0) -> Record:
    v = np.gradient(x, t)
    force = DAHL.force(t, x, velocity=v) + noise * np.random.default_rng(3).standard_normal(t.size)
    return Record(t, x, force, velocity=v, voltage=1.0, name="one")


def sine(t: np.ndarray = T, amplitude: float = 0.01) -> Record:
    return of_motion(amplitude * np.sin(2 * np.pi * t), t)


def random_motion(t: np.ndarray = T) -> np.ndarray:
    rng = np.random.default_rng(5)
    frequencies = np.geomspace(0.2, 3.0, 12)
    phases = rng.uniform(0.0, 2 * np.pi, 12)
    return 2e-3 * np.sum(np.sin(2 * np.pi * frequencies * t[:, None] + phases) / frequencies**0.5, axis=1)


def with_displacement(change: Callable[[np.ndarray], np.ndarray]) -> Record:
    record = sine()
    return record.replace(note="planted", displacement=change(np.array(record.displacement)))


def with_force(change: Callable[[np.ndarray], np.ndarray]) -> Record:
    record = sine()
    return record.replace(note="planted", force=change(np.array(record.force)))


def leapt(x: np.ndarray) -> np.ndarray:
    x[700:] += 4e-3
    return x


def lost_counts(x: np.ndarray) -> np.ndarray:
    steps = np.diff(x)
    return np.r_[x[0], x[0] + np.cumsum(np.where(steps < 0.0, 0.8 * steps, steps))]


def spiked(force: np.ndarray) -> np.ndarray:
    force[[500, 900]] += 0.7 * np.ptp(force)
    return force


def often_spiked(force: np.ndarray) -> np.ndarray:
    force[40::125] += 0.7 * np.ptp(force)
    return force


def noisy(x: np.ndarray) -> np.ndarray:
    return x + 3e-6 * np.random.default_rng(0).standard_normal(x.size)


PLANTED: dict[str, Callable[[], Record]] = {
    "created energy": lambda: with_force(lambda force: -force),
    "mark": lambda: replace_marks(sine()),
    "many repaired": lambda: repair(with_force(often_spiked), "false samples"),
    "certificate": lambda: with_expired_certificate(sine()),
    "label": lambda: sine().replace(note="planted", label=Label(0.02, 2.0)),
    "gap": lambda: sine(np.r_[T[:600], T[640:]]),
    "jitter": lambda: sine(T + 1.5e-4 * np.random.default_rng(2).standard_normal(T.size)),
    "saturated": lambda: with_force(lambda force: np.clip(force, -240.0, 240.0)),
    "false samples": lambda: with_force(spiked),
    "leap": lambda: with_displacement(leapt),
    "run away": lambda: with_displacement(lost_counts),
    "unlikely unit": lambda: sine(amplitude=1.5),
    "coarse": lambda: sine(T[::8]),
    "undeclared smoothing": lambda: rounded(smoothed(of_motion(noisy(random_motion()), noise=3.0), 40)),
    "noise": lambda: of_motion(noisy(random_motion())),
    "repaired": lambda: repair(with_force(spiked), "false samples"),
    "integrated": lambda: integrated(sine()),
    "irregular": lambda: of_motion(random_motion()),
    "declared smoothing": lambda: with_smoothing(smoothed(of_motion(random_motion(), noise=3.0), 40), "40 samples"),
}


def replace_marks(record: Record) -> Record:
    return record.replace(note="planted", marks=("the coil's supply was off for 2 s",))


def with_expired_certificate(record: Record) -> Record:
    certificates = Certificates(load_cell=RelativeCertificate(date(2025, 1, 1), date(2026, 1, 1), "4711"))
    started = {"started": "2026-03-01T10:00:00+00:00"}
    return record.replace(note="planted", provenance=started | certificates.provenance())


def rounded(record: Record) -> Record:
    return record.replace(
        note="planted", displacement=np.round(record.displacement, 7), force=np.round(record.force, 1)
    )


def integrated(record: Record) -> Record:
    return record.replace(note="planted", provenance={"displacement": f"{INTEGRATED}; drift of 0.1 mm removed"})


@pytest.fixture(scope="module")
def records() -> dict[str, Record]:
    """One record of each kind, of its name."""
    return {kind: made().replace(note="named", name=kind) for kind, made in PLANTED.items()}


@pytest.fixture(scope="module")
def said(records: dict[str, Record], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What every face of what is made of the records says, by face."""
    folder = tmp_path_factory.mktemp("kinds")
    card, page, building = (folder / name for name in ("card.toml", "page.html", "building.html"))
    files = [write(record, folder / f"{kind}.h5") for kind, record in records.items()]

    def call(*words: str | Path) -> str:
        with texts_alone():
            done = CliRunner().invoke(cli, [*map(str, words)], catch_exceptions=False)
        assert done.exit_code == 0, done.output
        return str(done.stdout) + (done.stderr if words[0] == "export" else "")

    # what a fit lacks, of records that are wrong on purpose, is another test's
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("dampyr.identification.fits.fit.list_missing_effects", lambda *_: ())
        faces = {"identify": call("identify", *files, "--model", "dahl", "--details", "--save", card, "--report", page)}
        faces["identify --json"] = call("identify", *files, "--model", "dahl", "--json")
    faces["card"], faces["page"] = card.read_text("utf-8"), unescape(page.read_text("utf-8"))
    shake = card, "--voltage", "1", "--allow-extrapolation"
    faces["simulate"] = call("simulate", *shake, "--report", building)
    faces["simulate --json"] = call("simulate", *shake, "--json")
    faces["page of the building"] = unescape(building.read_text("utf-8"))
    faces["ensemble"] = call("ensemble", *shake, "--synthetic", "2", "--duration", "3", "--out", folder / "peaks.h5")
    faces["ensemble --read"] = call("ensemble", "--read", folder / "peaks.h5")
    faces["export"] = call("export", card, "--to", "c", "--out", folder)
    faces["exported comment"] = (folder / "damper.h").read_text("utf-8").replace("\n *", "")
    return {face: " ".join(text.split()) for face, text in faces.items()}


def test_no_kind_is_without_a_record() -> None:
    clean = findings_by_kind(sine())
    assert list(clean) == list(PLANTED)
    assert [kind for kind, (_, words) in clean.items() if words] == []


@pytest.mark.parametrize("kind", PLANTED)
def test_the_record_has_it_and_says_so_itself(kind: str, records: dict[str, Record]) -> None:
    by_kind, findings = findings_by_kind(records[kind]), records[kind].findings
    severity, words = by_kind[kind]
    assert {name for name, (_, some) in by_kind.items() if some} - {"irregular"} <= {kind}
    assert {severity} == {one.severity for one in findings if one.words in words}
    assert str(findings[0])[:40] in repr(records[kind])


@pytest.mark.parametrize("kind", PLANTED)
def test_what_is_made_of_the_record_says_it_once(kind: str, records: dict[str, Record], said: dict[str, str]) -> None:
    severity, words = findings_by_kind(records[kind])[kind]
    head = " ".join(words[0].split())[:60]
    times = {face: text.count(head) for face, text in said.items()}
    assert set(times.values()) == {0 if severity == "note" else 1}, times  # notes stay with the record


@pytest.mark.prove
def test_a_card_holds_the_list_of_its_damper_and_hands_on_what_matters(
    records: dict[str, Record], tmp_path: Path
) -> None:
    fitted = fit(list(records.values()), "dahl")
    assert fitted.damper is not None
    loaded = Damper.load(fitted.damper.save(tmp_path / "card.toml"))
    assert tuple(loaded.findings) == tuple(fitted.damper.findings)
    matters = [replace(one, source=OF_DAMPER) for one in fitted.damper.findings if one.severity != "note"]
    assert len(matters) > 12
    assert list(handed_on([loaded], OF_DAMPER)) == matters
    assert list(respond(two_storey(), el_centro(), {1: loaded}, voltage=1.0).findings)[: len(matters)] == matters
