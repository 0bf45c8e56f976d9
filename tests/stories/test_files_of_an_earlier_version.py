"""Files that earlier versions wrote load as they did there: tests/fixtures, where a README.md says what each folder holds.

What is only read is compared to the last bit. What is computed anew from it (a force, the rest of an ensemble) is compared to
rounding: kernels are compiled for the processor that runs them, and another one may fuse a multiplication and an addition.
"""

import dataclasses
import hashlib
import json
import os
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import DampyrWarning, FileError

FIXTURES = Path(__file__).parents[1] / "fixtures"
COMMITS = ("b829dc7", "22f2912")
EXPECTED = {commit: json.loads((FIXTURES / commit / "expected.json").read_text("utf-8")) for commit in COMMITS}
CARDS, RECORDS, CAMPAIGNS = (
    [(commit, name) for commit in COMMITS for name in sorted(EXPECTED[commit][kind])]
    for kind in ("cards", "records", "campaigns")
)
ROUNDING = 1e-12  # of the largest force along the path: the processor's, see above
CHANGED_FORCES = {
    (
        "b829dc7",
        "velocity_memory_in_series.toml",
    ): "0.2.0, decision 19: behind a compliance its memory follows the piston's velocity",
}


def sha256(values: Any) -> str:
    return hashlib.sha256(np.ascontiguousarray(values, dtype="<f8").tobytes()).hexdigest()


def as_json(value: Any) -> Any:
    """As `value` stands in expected.json: tuples are lists, floats keep every bit."""
    return json.loads(json.dumps(value))


@pytest.fixture(params=COMMITS)
def commit(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def files(commit: str, tmp_path: Path) -> Path:
    """A copy: campaigns and ensembles are gone on with in their files."""
    ignored = shutil.ignore_patterns("make.py", "expected.json")
    return Path(shutil.copytree(FIXTURES / commit, tmp_path / "files", ignore=ignored))


# Cards


@pytest.mark.parametrize(("commit", "name"), CARDS)
def test_a_card_loads_identically(commit: str, name: str, tmp_path: Path) -> None:
    damper, expected = dp.models.Damper.load(FIXTURES / commit / "cards" / name), EXPECTED[commit]["cards"][name]
    assert list(damper.parts) == expected["parts"]
    assert (damper.input, damper.bandwidth, list(damper.range)) == tuple(
        expected[key] for key in ("input", "bandwidth", "range")
    )
    assert {key: list(span) for key, span in damper.ranges.items()} == expected["ranges"]
    assert list(damper.laws) == list(expected["laws"])
    for key, law in damper.laws.items():
        read = {each: getattr(law, each) for each in ("kind", "low", "high", "coefficients")}
        assert as_json(read | {"knots": getattr(law, "knots", ())}) == expected["laws"][key]
    assert sha256(damper.coefficients) == expected["coefficients"]
    assert (None if damper.covariance is None else damper.covariance.tolist()) == expected["covariance"]
    assert dict(damper.provenance) == expected["provenance"]
    again = damper.save(tmp_path / name)
    old = tomllib.loads((FIXTURES / commit / "cards" / name).read_text("utf-8"))
    old["damper"] |= {"origin": "not stated"}  # a card of before does not say what it was identified from
    if "dampyr" in old.get("provenance", {}):
        old["origin"] = {"versions": [old["provenance"]["dampyr"]]}
    assert tomllib.loads(again.read_text("utf-8")) == old


LONG_TO_COMPILE = ("published_with_eta", "velocity_memory_in_series", "with_add_ons", "over_current")


@pytest.mark.parametrize(
    ("commit", "name"),
    [
        pytest.param(*card, marks=[pytest.mark.prove] * card[1].startswith(LONG_TO_COMPILE))
        for card in CARDS
        if card not in CHANGED_FORCES
    ],
)
def test_the_force_of_a_card_is_what_it_was(commit: str, name: str) -> None:
    damper, expected = (
        dp.models.Damper.load(FIXTURES / commit / "cards" / name),
        EXPECTED[commit]["cards"][name]["forces"],
    )
    t, x, course = (np.array(EXPECTED[commit]["path"][key]) for key in ("time", "displacement", "course"))
    (low, high), argument = damper.range, {"V": "voltage", "A": "current"}[damper.input]
    for value, old in zip((low, 0.5 * (low + high), high, low + course * (high - low)), expected, strict=True):
        force = damper.force(t, x, **{argument: value})
        if sha256(force) != old["sha256"]:
            close = ROUNDING * float(np.abs(force).max())
            np.testing.assert_allclose(force[::20], old["every_20th"], rtol=0, atol=close)


def test_a_card_of_a_published_set_is_as_it_was_written() -> None:
    """Since 0.2.0 the set itself has its rate eta, as the part lag; a card that was written before has none."""
    assert "lag" not in dp.models.Damper.load(FIXTURES / "b829dc7/cards/published_with_eta.toml").parts
    assert "lag" in dp.models.published.damper("tan_agrawal_2004").parts


# Records


def check_record(record: Any, expected: dict[str, Any]) -> None:
    assert (record.name, record.role) == (expected["name"], expected["role"])
    for name in ("time", "displacement", "force", "velocity", "voltage", "current", "temperature"):
        value, old = getattr(record, name), expected["channels"].get(name)
        if old is None:
            assert value is None, name
        elif "constant" in old:
            assert (type(value), value) == (float, old["constant"]), name
        else:
            assert (len(value), sha256(value)) == (old["samples"], old["sha256"]), name
    assert (None if record.label is None else dataclasses.asdict(record.label)) == expected["label"]
    assert dict(record.provenance) == expected["provenance"]
    assert list(record.history) == expected["history"]
    for name in ("measurement_session", "specimen"):  # b829dc7 knew neither
        assert getattr(record, name) == expected.get(name), name


@pytest.mark.parametrize(("commit", "name"), RECORDS)
def test_a_record_reads_identically(commit: str, name: str) -> None:
    options = EXPECTED[commit]["record_options"].get(name, {})
    check_record(dp.records.read(FIXTURES / commit / "records" / name, **options), EXPECTED[commit]["records"][name])


# Rig and campaigns


def test_a_rig_loads_identically(commit: str) -> None:
    loaded = dataclasses.asdict(dp.rig.load_settings(FIXTURES / commit / "rig.toml"))
    since = dataclasses.asdict(dp.rig.RigSettings())  # what has come since then has its default
    expected = {
        name: since[name] | value if isinstance(value, dict) else value
        for name, value in EXPECTED[commit]["rig"].items()
    }
    expected |= {name: since[name] for name in ("uno", "certificates")}
    assert loaded == expected


@pytest.mark.parametrize(("commit", "name"), CAMPAIGNS)
def test_a_campaign_loads_identically(commit: str, name: str) -> None:
    campaign, expected = dp.campaigns.read(FIXTURES / commit / "campaigns" / name), EXPECTED[commit]["campaigns"][name]
    newer = {"measurement_session": "", "specimen": "", "learn": False}
    assert dataclasses.asdict(campaign.header) == newer | expected["header"]
    assert len(campaign.tests) == len(expected["tests"])
    for test, old in zip(campaign.tests, expected["tests"], strict=True):
        step = as_json(dataclasses.asdict(test.step))
        if "motion" in step:
            step["motion"] = step["motion"].removeprefix(f"{FIXTURES / commit / 'campaigns'}{os.sep}")
        read = {key: getattr(test, key) for key in ("number", "step_number", "kind", "repeat", "name", "words")}
        later = {"fit_limits": False} if test.kind == "sweep" else {}  # a field that those files do not have
        assert read | {"step": step} == old | {"step": later | old["step"]}


def test_every_kind_of_step_is_in_a_campaign(commit: str) -> None:
    tests = EXPECTED[commit]["campaigns"]["every_kind.toml"]["tests"]
    assert {test["kind"] for test in tests} <= set(dp.campaigns.available_steps())


@pytest.mark.parametrize("name", ["complete_campaign", "stopped_campaign"])
def test_the_folder_of_a_campaign_reads_identically(commit: str, name: str, files: Path) -> None:
    expected = EXPECTED[commit]["folders"][name]
    for incomplete, old in ((False, expected["records"]), (True, expected["incomplete_too"])):
        records = dp.records.read_campaign(files / name, role=None, incomplete=incomplete)
        assert len(records) == len(old)
        for record, each in zip(records, old, strict=True):
            check_record(record, each)
            assert record.origin.kind == "simulated"  # the board tells: the files have no mark
    tests, events = dp.campaigns.read_journal(files / name)
    assert [dataclasses.asdict(test) for test in tests] == expected["tests"]
    assert [dataclasses.asdict(event) for event in events] == expected["events"]


def content(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("*.h5")}


def nothing_runs(progress: Any) -> None:
    raise AssertionError(f"{progress.phase} {progress.name}, though every test is complete")


def test_a_complete_campaign_is_not_run_again(files: Path) -> None:
    """Also where its journal was lost: its records say which tests are complete."""
    folder, campaign = files / "complete_campaign", files / "campaigns/two_tests.toml"
    before, (tests, events) = content(folder), dp.campaigns.read_journal(folder)
    with dp.rig.simulated(files / "rig.toml") as rig:
        dp.campaigns.perform(campaign, rig, folder, nothing_runs)
        assert dp.campaigns.read_journal(folder) == (tests, events)
        (folder / "journal.sqlite").unlink()
        with pytest.warns(DampyrWarning, match="2 complete, 0 not"):
            dp.campaigns.perform(campaign, rig, folder, nothing_runs)
    assert [(test.name, test.state) for test in dp.campaigns.read_journal(folder)[0]] == [
        (test.name, "complete") for test in tests
    ]
    assert content(folder) == before


def test_a_stopped_campaign_goes_on_where_it_stopped(files: Path) -> None:
    folder = files / "stopped_campaign"
    before, [first] = content(folder), dp.records.read_campaign(folder)
    with dp.rig.simulated(files / "rig.toml") as rig:
        dp.campaigns.perform(files / "campaigns/two_tests.toml", rig, folder)
    after, (tests, _) = content(folder), dp.campaigns.read_journal(folder)
    assert {name: after[name] for name in before} == before
    assert len(after) == len(before) + 1
    assert [(test.state, test.attempt) for test in tests] == [("complete", 1), ("complete", 2)]
    records = dp.records.read_campaign(folder)
    assert [record.name for record in records] == [test.name for test in tests]
    old, new = (json.loads(record.provenance["calibration"]) for record in (first, records[1]))
    assert new | {"middle": 0.0} == old | {"middle": 0.0}  # calibration.toml, but for what homing measures each time


# Ensembles. Which cases a file holds is a digest of numpy's pickles and of the laws' repr. Where one of the two changes, files
# of before are refused as another ensemble.


def ensemble_arguments(folder: Path) -> tuple[tuple[Any, ...], dict[str, Any], dict[str, Any]]:
    """Of the ensembles, as make.py wrote them: those of the complete one, and of the one that was interrupted."""
    ground = dp.ground_motions.read(folder / "campaigns/motion.txt")
    card = dp.models.Damper.load(folder / "cards/dahl_cubic_laws.toml")
    law = dp.structures.control_law("on_off", high=3.0, period=0.02)
    complete = {"dampers": [None, card, {2: card}], "voltage": [0.0, 1.98, law], "scales": [0.5, 1.0, 2.0]}
    inputs, scales = [0.4 * k for k in range(8)], [k / 128 for k in range(1, 257)]
    interrupted = {"dampers": card, "voltage": inputs, "scales": scales, "quantities": ("displacement",)}
    first = (dp.structures.two_storey(), [ground, ground.scaled(-0.5)])
    return first, complete, interrupted


def check_labels(data: Any, expected: dict[str, Any]) -> None:
    assert dict(data.sizes) == expected["sizes"]
    for name, old in expected["labels"].items():
        assert list(data[name].dims) == old["dims"]
        np.testing.assert_array_equal(data[name].values, np.array(old["values"]))


@pytest.mark.parametrize("name", ["complete.h5", "parts"])
def test_an_ensemble_reads_identically(commit: str, name: str, files: Path) -> None:
    path, expected = files / "ensembles" / name, EXPECTED[commit]["ensembles"][name]
    data = dp.structures.read_ensemble(path).dataset if path.is_file() else dp.structures.collect(path).dataset
    check_labels(data, expected)
    assert dict(data.attrs) == expected["attributes"] | {"damper_origin": "not stated"}
    assert list(data.data_vars) == list(expected["peaks"])
    for quantity, old in expected["peaks"].items():
        peaks = data[quantity]
        assert (list(peaks.dims), peaks.attrs["units"], sha256(peaks)) == (old["dims"], old["units"], old["sha256"])


def without_origin(data: Any) -> Any:
    """The data of an ensemble but for its origin, of which a file of before states the kind alone."""
    return data.assign_attrs(damper_origin="")


def test_an_ensemble_whose_laws_were_computed_otherwise_is_read_and_not_mixed_with_new_cases(files: Path) -> None:
    """Its cases under laws were run one by one; what is there stays as it is, and the sentence says why it is not continued."""
    first, complete, _ = ensemble_arguments(files)
    path, parts = files / "ensembles/complete.h5", files / "ensembles/parts"
    before = content(parts) | content(path.parent)
    for again in (
        lambda: dp.structures.ensemble(*first, **complete, out=path),
        lambda: dp.structures.write_part(dp.structures.ensemble_cases(*first, **complete), 1, 2, parts),
    ):
        with pytest.raises(FileError, match=r"another version computed .it can be read, not continued."):
            again()
    assert content(parts) | content(path.parent) == before


def test_what_is_complete_of_an_ensemble_is_not_computed_again(files: Path, tmp_path: Path) -> None:
    first, complete, _ = ensemble_arguments(files)
    path, parts, steps = tmp_path / "ensemble" / "complete.h5", tmp_path / "ensemble" / "parts", list[tuple[int, int]]()
    parts.mkdir(parents=True)
    dp.structures.ensemble(*first, **complete, out=path)
    for part in (1, 2):
        dp.structures.write_part(dp.structures.ensemble_cases(*first, **complete), part, 2, parts)
    before = content(path.parent)
    data = dp.structures.ensemble(*first, **complete, out=path, progress=lambda *done: steps.append(done)).dataset
    assert data.identical(dp.structures.read_ensemble(path).dataset)
    for part in (1, 2):
        dp.structures.write_part(
            dp.structures.ensemble_cases(*first, **complete), part, 2, parts, progress=lambda *done: steps.append(done)
        )
    assert steps == []
    assert content(path.parent) == before


def test_an_interrupted_ensemble_is_taken_up(commit: str, files: Path) -> None:
    """One shard of two is in the file; the result is that of the whole."""
    first, _, interrupted = ensemble_arguments(files)
    path, steps = files / "ensembles/interrupted.h5", []
    data = dp.structures.ensemble(*first, **interrupted, out=path, progress=lambda *done: steps.append(done)).dataset
    assert steps == [(4096, 4096)]
    assert without_origin(data).identical(without_origin(dp.structures.read_ensemble(path).dataset))
    expected = EXPECTED[commit]["ensembles"]["interrupted.h5"]
    check_labels(data, expected)
    [(quantity, old)] = expected["peaks"].items()
    if sha256(data[quantity]) != old["sha256"]:
        np.testing.assert_allclose(data[quantity].values.ravel()[::64], old["every_64th"], rtol=1e-9)
