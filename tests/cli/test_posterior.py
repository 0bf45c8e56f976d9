"""``dampyr posterior``: the numbers of `sample_posterior`, and what the page and the table say of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import dampyr as dp
from dampyr import records
from dampyr.cli import cli
from dampyr.identification import fit, sample_posterior

pytest.importorskip("emcee")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four noisy sines of a damper at 0 V and at 1 V."""
    place = tmp_path_factory.mktemp("posterior")
    damper = dp.models.Damper("dahl", {"dahl.kx": 1300.0, "dahl.kw": 210.0, "dahl.rho": 6000.0})
    t, rng = np.arange(0.0, 4.0, 0.01), np.random.default_rng(3)
    for k in range(8):
        x = (0.004 + 0.001 * k) * np.sin(2 * np.pi * (0.6 + 0.1 * k) * t)
        force = damper.force(t, x, voltage=0.0) + rng.normal(0.0, 5.0, t.size)
        records.write(records.Record(t, x, force, voltage=float(k % 2), name=f"test {k}"), place / f"test {k}.h5")
    return place


@pytest.mark.prove
def test_the_command_samples_what_python_samples(folder: Path, tmp_path: Path) -> None:
    words = ["posterior", str(folder), "--model", "dahl", "--lengths", "4", "--seed", "2"]
    page = tmp_path / "page.html"
    said = json.loads(CliRunner().invoke(cli, [*words, "--json", "--report", str(page)], catch_exceptions=False).stdout)
    ours = sample_posterior(fit(records.read_records(folder), "dahl", seed=2), 4, seed=2)
    assert said["median"] == {label: float(np.median(values)) for label, values in ours.samples.items()}
    assert said["intervals_95"]["dahl.kw @ 0 V"] == pytest.approx(ours.intervals()["dahl.kw @ 0 V"], rel=1e-12)
    text = page.read_text("utf-8")
    assert text.count("<figure>") == 2  # one for each input: their numbers hang together with no others
    assert "At 1 V" in text


def test_the_fit_stands_beside_the_samples_and_chains_that_are_short_say_so(folder: Path) -> None:
    shown = CliRunner().invoke(cli, ["posterior", str(folder), "--model", "dahl", "--lengths", "2"])
    assert shown.exit_code == 0
    assert "fit, from" in shown.stdout
    assert "Did not converge" in shown.stdout
    assert "autocorrelation time" in shown.stdout


@pytest.mark.prove
def test_what_is_simulated_says_so(folder: Path, tmp_path: Path) -> None:
    for path in folder.glob("*.h5"):
        records.write(records.read(path).replace(note="as simulated", origin="simulated"), tmp_path / path.name)
    words = ["posterior", str(tmp_path), "--model", "dahl", "--lengths", "2", "--report", str(tmp_path / "page.html")]
    shown = CliRunner().invoke(cli, words, catch_exceptions=False)
    assert shown.stdout.splitlines()[0].startswith("SIMULATED")
    text = (tmp_path / "page.html").read_text("utf-8")
    assert text.count("SIMULATED") >= 1 + text.count("<figure>")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--model", "dahl", "--lengths", "0"], "'--lengths': 0.0 is not in the range x>0"),
        (["--model", "dahl", "--chain-steps", "3"], "'--chain-steps': 3 is not in the range x>=100"),
        (["--model", "nothing"], "nothing"),
        ([], "--model"),
    ],
)
def test_what_is_wrong_is_said(folder: Path, words: list[str], sentence: str) -> None:
    done = CliRunner().invoke(cli, ["posterior", str(folder), *words])
    assert done.exit_code != 0
    assert sentence in f"{done.stderr}{done.exception}"
