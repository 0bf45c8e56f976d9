"""dampyr ensemble: cases, limits, files taken up, parts put together."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.cli._ensemble import Rate, _lines, scales, shard
from dampyr.errors import InputError
from dampyr.ground_motions import kanai_tajimi
from dampyr.structures import ensemble, fragility, two_storey
from dampyr.structures.ensembles.peak_limits import Limit, limit_of
from dampyr.studies import raminelli_2020

CASES = ("--voltage", "0", "--voltage", "1.98", "--synthetic", "4", "--duration", "4", "--scale", "0.2:2:0.6")


def call(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["ensemble", *arguments], catch_exceptions=False)


def ensemble_json(*arguments: str) -> dict:
    done = call(*arguments, "--json")
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


@pytest.mark.prove
def test_it_is_what_the_functions_give() -> None:
    got = ensemble_json(*CASES, "--without-damper", "--limit", "12mm", "--limit", "1%", "--height", "3 m")
    motions = [kanai_tajimi(4.0, 0.01, (1, k), pga=0.3 * 9.80665) for k in range(1, 5)]
    data = ensemble(two_storey(), motions, [None, raminelli_2020.damper()], [0.0, 1.98], [0.2, 0.8, 1.4, 2.0]).dataset
    assert got["cases"] == 64
    assert got["error_estimate"] == data.attrs["error_estimate"]
    for one, expected in zip(
        got["fragility"], (fragility(data, limit=0.012, seed=1), fragility(data, height=3.0, seed=1))
    ):
        assert [c["name"] for c in one["curves"]] == ["no damper", "0 V", "1.98 V"]
        for curve, same in zip(one["curves"], expected.curves):
            assert (curve["theta"] or np.nan) == pytest.approx(same.theta, nan_ok=True)
            assert curve["reason"] == same.reason
    rows = {(row["name"], row["scale"]): row["peaks"] for row in got["peaks"]}
    bare = data.drift.isel(damper=0, input=0).sel(scale=1.4).max("storey").median()
    assert rows["no damper", 1.4]["drift"][0] == pytest.approx(float(bare))
    assert rows["no damper", 1.4]["force"] is None


def test_the_table_tells_the_limits_and_the_step() -> None:
    done = call(*CASES, "--limit", "12mm", "--limit", "50g")
    assert done.exit_code == 0, done.output
    assert "peaks of 32 cases" in done.stdout
    assert "no curve; no case exceeds the limit" in done.stdout
    assert "halving the step" in done.stdout


@pytest.mark.prove
def test_the_table_and_the_page(tmp_path: Path) -> None:
    done = call(*CASES, "--limit", "12mm", "--limit", "50g", "--report", str(tmp_path / "page.html"))
    assert done.exit_code == 0, done.output
    assert "peaks of 32 cases" in done.stdout
    assert "no curve; no case exceeds the limit" in done.stdout
    assert "halving the step" in done.stdout
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    for words in (
        "drift above 12 mm",
        "Incremental analysis",
        "no case exceeds the limit",
        "84 %",
        "Accuracy",
    ):
        assert words in page
    assert page.count("<svg") == 4
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"', "", page)


def test_a_file_is_taken_up_and_read(tmp_path: Path) -> None:
    out = str(tmp_path / "e.h5")
    first = ensemble_json(*CASES, "--out", out)
    again = call(*CASES, "--out", out)
    assert "e.h5: 1 of 1 shards are there; going on" in again.stderr
    assert ensemble_json("--read", out) == first
    done = call("--read", out, "--voltage", "1")
    assert done.exit_code == 2
    assert "--voltage says what to compute, and --read takes what was computed" in done.stderr


@pytest.mark.prove
def test_parts_in_processes_of_their_own(tmp_path: Path) -> None:
    """As a batch system runs them, with the number of the part in the environment."""
    parts, out = tmp_path / "parts", tmp_path / "all.h5"
    command = f"{sys.executable} -m dampyr ensemble {' '.join(CASES)} --shard $SLURM_ARRAY_TASK_ID/2 --out {parts}"
    for k in ("2", "1"):
        subprocess.run(["/bin/sh", "-c", command], check=True, env={**os.environ, "SLURM_ARRAY_TASK_ID": k})
        if k == "2":
            done = call("--collect", str(parts))
            assert done.exit_code == 2
            assert "1 of 2 parts are missing: 1" in done.stderr
    collected, whole = ensemble_json("--collect", str(parts), "--out", str(out)), ensemble_json(*CASES)
    assert collected["peaks"] == whole["peaks"]
    assert ensemble_json("--read", str(out)) == collected


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "this damper takes a voltage; give --voltage"),
        (("--voltage", "0", "--limit", "12"), "'12' has no unit"),
        (("--voltage", "0", "--limit", "12 s"), "write it as in 12mm, 1% or 0.5g"),
        (("--voltage", "0", "--limit", "1%"), "is a ratio of the storey height"),
        (("--voltage", "0", "--limit", "12mm", "--height", "3m"), "height belongs to a limit in per cent"),
        (("--voltage", "0", "--scale", "2:1:0.1"), "'2:1:0.1' is neither a number nor a range"),
        (("--voltage", "0", "--scale", "1,1"), "1 is given twice"),
        (("--voltage", "0", "--shard", "3/2", "--out", "x"), "'3/2' is not a part"),
        (("--voltage", "0", "--shard", "1/2"), "name it with --out"),
        (("--voltage", "0", "--shard", "1/2", "--collect", "x"), "exclude each other"),
        (("--voltage", "0", "--shard", "1/2", "--out", "x", "--limit", "12mm"), "a part alone has no results yet"),
        (("--voltage", "0", "--draws", "3"), "no covariance to draw from"),
        (("--voltage", "0", "--dt", "0.01"), "belong to files that are given with --motion"),
        (("--voltage", "9"), "range"),
        (("--collect", "nowhere"), "holds no part of an ensemble"),
        (("--read", "nowhere.h5"), "is not there"),
        (("--voltage", "0", "--storey", "1", "--between", "0", "2"), "both --storey and --between"),
    ],
)
def test_what_is_wrong_is_one_line(
    arguments: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = call(*arguments)
    assert done.exit_code == 2
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_scales_and_limits_and_shards() -> None:
    assert scales(("0.1:0.5:0.1", "2,3")) == [0.1, 0.2, 0.3, 0.4, 0.5, 2.0, 3.0]
    assert scales(("0.1:3:0.1",)) == [float(f"{0.1 * k:.12g}") for k in range(1, 31)]
    assert scales(()) == [1.0]
    assert limit_of("12mm") == Limit("drift", 0.012)
    acceleration = limit_of("0.5g")
    assert acceleration == Limit("acceleration", acceleration.value)
    assert acceleration.value == pytest.approx(4.903325)
    assert limit_of("1 %", 3.0) == Limit("drift", 0.01, 3.0)
    assert limit_of("force=1kN") == Limit("force", 1000.0)
    assert shard("3/32") == (3, 32)
    with pytest.raises(InputError, match="counted from 1"):
        shard("0/4")


def test_progress_tells_rate_and_time_left(capsys: pytest.CaptureFixture[str]) -> None:
    now = [0.0]
    show = _lines(100, clock=lambda: now[0])
    for now[0], done in ((1.0, 200), (10.0, 600), (20.0, 1100)):
        show(done, 1100)
    assert capsys.readouterr().err.splitlines() == [
        "600 of 1100 cases, 50 cases/s, 10 s left",
        "1100 of 1100 cases, 50 cases/s, 0 s left",
    ]
    assert Rate(0, lambda: 0.0).of(0) == 0


@pytest.mark.prove
def test_control_laws_stand_among_the_inputs() -> None:
    got = ensemble_json("--voltage", "0", "--control", "on_off:period=10ms", "--synthetic", "1", "--duration", "3")
    assert [row["name"] for row in got["peaks"]] == ["0 V", "on_off 0 to 3.212 V, period 0.01 s"]
    assert (got["one_by_one"], got["judged_under_laws"]) == (0, 1)
