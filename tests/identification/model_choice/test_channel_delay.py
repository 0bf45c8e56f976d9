"""A force that was sampled later or earlier than the displacement: said by a fit, and repaired by what it says."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import dampyr as dp
from dampyr.cli import cli
from dampyr.identification.model_choice import channel_delay
from dampyr.records import Record

DAHL = dp.Damper("dahl", {"dahl.kx": 1200.0, "dahl.kw": 200.0, "dahl.rho": 2000.0})
BOUC_WEN = dp.Damper(
    "bouc_wen",
    {
        "bouc_wen.c0": 800.0, "bouc_wen.k0": 500.0, "bouc_wen.kw": 120.0, "bouc_wen.rho": 900.0, "bouc_wen.sigma": 0.8,
        "bouc_wen.n": 1.5,
    },
)  # fmt: skip


def sampled_late(damper: dp.Damper, delay: float, frequency: float = 1.0, noise: float = 0.005) -> Record:
    """A sine of 10 mm with a force that is ``delay`` [s] late, and noise of a part of its standard deviation."""
    t = np.arange(0.0, 6.0, 0.001)
    x = 0.01 * np.sin(2.0 * np.pi * frequency * t)
    force = damper.force(t, x, velocity=np.gradient(x, t), voltage=0.0)
    force = np.interp(t - delay, t, force) + np.random.default_rng(7).normal(0.0, noise * np.std(force), t.size)
    return Record(t, x, force, voltage=0.0, name=f"{frequency:g} Hz")


def delays(fit: dp.identification.Fit) -> list[str]:
    return [finding.words for finding in fit.findings if "force_delay" in finding.words]


@pytest.mark.parametrize("delay", [0.010, -0.010, 0.003, -0.003])
def test_a_delay_is_told_and_what_is_told_repairs_it(delay: float, tmp_path: Path) -> None:
    """With 10 ms at 1 Hz the plain fit has kx 15 % and rho 25 to 40 % off, at a misfit of 2 %."""
    for frequency in (1.0, 0.5):
        dp.records.write(sampled_late(DAHL, delay, frequency), tmp_path / f"{frequency}.csv")
    plain = dp.fit(tmp_path, "dahl")
    assert abs(plain.parameters["dahl.rho"] / 2000.0 - 1.0) > 0.08
    [words] = delays(plain)
    stated = float(re.search(r"force_delay=(-?[\d.]+)", words)[1])  # type: ignore[index]
    assert stated == pytest.approx(delay, rel=0.03)
    assert any("force_delay" in finding.words for finding in plain.damper.findings)  # its card says it, too
    repaired = dp.fit(dp.records.read_records(tmp_path, force_delay=stated), "dahl")
    assert list(repaired.parameters.values()) == pytest.approx([1200.0, 200.0, 2000.0], rel=0.01)
    assert delays(repaired) == []
    assert "motion delayed by" in repaired.records[0].history[-1]


@pytest.mark.parametrize(
    ("damper", "delay", "model"),
    [
        (DAHL, 0.0, "dahl"),
        (BOUC_WEN, 0.0, "dahl"),  # another misfit
        (BOUC_WEN, 0.0, "bingham"),  # without a memory every hysteresis is a delay
        (DAHL, 0.010, "dahl + delay"),
    ],
    ids=["none", "another model", "no memory", "a delay in the model"],
)
@pytest.mark.usefixtures("no_trials")
def test_nothing_is_said_where_nothing_was_late(damper: dp.Damper, delay: float, model: str) -> None:
    assert delays(dp.fit([sampled_late(damper, delay), sampled_late(damper, delay, 0.5)], model)) == []


def test_a_residual_of_white_noise_is_not_looked_into(monkeypatch: pytest.MonkeyPatch) -> None:
    def looked(*of: object) -> None:
        raise AssertionError("the delay of white noise was estimated")

    monkeypatch.setattr(channel_delay, "_common_delay", looked)
    assert delays(dp.fit(sampled_late(DAHL, 0.0), "dahl")) == []
    with pytest.raises(AssertionError, match="white noise"):
        dp.fit(sampled_late(DAHL, 0.003), "dahl")


@pytest.mark.parametrize("samples_a_cycle", [8, 20, 200])
def test_the_share_that_is_told_is_no_white_noise(samples_a_cycle: int) -> None:
    """What a delay takes up least of a residual, beside white noise, on records that are sampled ever so coarsely."""
    t = np.arange(0.0, 40.0, 1.0 / samples_a_cycle)
    force = DAHL.force(t, 0.01 * np.sin(2.0 * np.pi * t), voltage=0.0)
    slope = np.gradient(force, t)
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal(t.size)
        share = channel_delay.SHARE
        mixed = np.sqrt(share) * slope / np.std(slope) + np.sqrt(1.0 - share) * noise
        assert not channel_delay._is_noise(mixed)


def test_a_varying_input_and_a_motion_that_cannot_be_moved_are_left_alone() -> None:
    record = sampled_late(DAHL, 0.01)
    varying = record.replace(note="a measured voltage", voltage=1.0 + 0.5 * np.sin(record.time))
    assert (
        delays(dp.fit(varying, "dahl", laws={"dahl.kx": "constant", "dahl.kw": "constant", "dahl.rho": "constant"}))
        == []
    )


def test_a_folder_declares_it_once(tmp_path: Path) -> None:
    dp.records.write(sampled_late(DAHL, 0.01), tmp_path / "late.csv")
    (tmp_path / "reading.toml").write_text('force_delay = "10 ms"\n')
    [record] = dp.records.read_records(tmp_path)
    assert record.history[-1].startswith("motion delayed by 0.01 s to meet the force")


def test_the_option_is_typed_with_its_unit(tmp_path: Path) -> None:
    path = dp.records.write(sampled_late(DAHL, 0.01), tmp_path / "late.csv")
    words = ["identify", str(path), "--model", "dahl", "--json"]
    found = [
        CliRunner().invoke(cli, [*words, *more], catch_exceptions=False) for more in ([], ["--force-delay", "10ms"])
    ]
    assert "--force-delay" in found[0].stdout
    assert "--force-delay" not in found[1].stdout
    refused = CliRunner().invoke(cli, [*words, "--force-delay", "9s"])
    assert refused.exit_code == 2
    assert "not a possible delay of a record of" in refused.output
