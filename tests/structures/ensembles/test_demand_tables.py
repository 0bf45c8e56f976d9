"""Peaks as pelicun reads them: labels, units and numbers, of every damper and input."""

from io import StringIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.structures import demand_tables, ensemble, respond, two_storey, write_demands
from dampyr.structures.ensembles.ensemble_result import EnsembleResult

HEIGHTS = (3.5, 3.0)


@pytest.fixture(scope="module")
def result() -> EnsembleResult:
    damper = dp.studies.raminelli_2020.damper()
    return ensemble(two_storey(), dp.ground_motions.el_centro(), [None, damper], [0.0, 1.98], [0.5, 1.0])


def test_a_table_for_the_bare_building_and_for_each_input(result: EnsembleResult) -> None:
    tables = demand_tables(result.dataset, HEIGHTS)
    assert list(tables) == ["no damper", "damper, 0 V", "damper, 1.98 V"]
    bare = tables["no damper"]
    motion = dp.ground_motions.el_centro()
    response = respond(two_storey(), motion)
    np.testing.assert_allclose(bare["1-PFA-0-1"], [0.5 * motion.pga, motion.pga])
    np.testing.assert_allclose(bare.loc[1, ["1-PFA-1-1", "1-PFA-2-1"]], response.peak_acceleration, rtol=5e-3)
    np.testing.assert_allclose(bare.loc[1, ["1-PID-1-1", "1-PID-2-1"]], response.peak_drift / HEIGHTS, rtol=5e-3)
    np.testing.assert_allclose(bare.loc[0, ["1-PFD-1-1", "1-PFD-2-1"]], 0.5 * response.peak_displacement, rtol=5e-3)
    assert (tables["damper, 1.98 V"]["1-PID-1-1"] < bare["1-PID-1-1"]).all()
    assert bare.attrs["left_out"] == 0


def test_the_files_are_those_that_pelicun_reads(result: EnsembleResult, tmp_path: Path) -> None:
    """A header with an empty first cell, a row of units that pelicun knows, and a row a realisation."""
    paths = write_demands(result.dataset, HEIGHTS, tmp_path / "demands")
    assert [path.name for path in paths] == [
        "demands_no_damper.csv", "demands_damper_0_V.csv", "demands_damper_1.98_V.csv", "about.txt",
    ]  # fmt: skip
    text = paths[0].read_text("utf-8")
    assert text.startswith(",1-PFA-0-1,1-PFA-1-1,1-PFA-2-1,1-PID-1-1,1-PID-2-1,1-PFD-1-1,1-PFD-2-1\n")
    read = pd.read_csv(StringIO(text), index_col=0)
    assert list(read.index) == ["Units", "0", "1"]
    assert set(read.loc["Units"]) == {"mps2", "rad", "m"}
    table = demand_tables(result.dataset, HEIGHTS)["no damper"]
    np.testing.assert_array_equal(read.drop("Units").astype(float).to_numpy(), table.to_numpy())


def test_a_case_without_a_peak_is_left_out_and_counted(result: EnsembleResult, tmp_path: Path) -> None:
    lost = result.dataset.copy(deep=True)
    lost.drift[0, 0, :, 0, 1] = np.nan
    table = demand_tables(lost, 3.0)["no damper"]
    assert len(table) == table.attrs["left_out"] == 1
    *_, about = write_demands(lost, 3.0, tmp_path)
    assert "demands_no_damper.csv: 1 realisation of no damper, 1 case without a peak left out\n" in about.read_text(
        "utf-8"
    )


def test_two_buildings_of_one_name_are_two_tables() -> None:
    motion = dp.ground_motions.el_centro()
    twice = ensemble([two_storey(), two_storey()], motion, [None], scales=[1.0]).dataset
    names = list(demand_tables(twice, 3.0))
    assert len(set(names)) == 2
    assert names[1] == f"{names[0]} (2)"


def test_what_is_simulated_says_so(tmp_path: Path) -> None:
    data = ensemble(two_storey(), dp.ground_motions.el_centro(), scales=[1.0]).dataset
    data.attrs["damper_origin"] = '{"kind": "simulated"}'
    *_, about = write_demands(data, 3.0, tmp_path)
    assert "simulated" in about.read_text("utf-8").lower()


@pytest.mark.parametrize("height", [0.0, -3.0, (3.0, 3.0, 3.0), float("nan")])
def test_a_height_that_is_none_is_refused(result: EnsembleResult, height: object) -> None:
    with pytest.raises(InputError, match="give one, or one for each of 2 storeys, above 0"):
        demand_tables(result.dataset, height)


def test_without_drifts_or_accelerations_it_says_so(result: EnsembleResult) -> None:
    with pytest.raises(InputError, match="has no drift; compute it with these quantities"):
        demand_tables(result.dataset.drop_vars("drift"), 3.0)


def test_the_command_writes_them_and_asks_for_a_height(tmp_path: Path) -> None:
    words = ["ensemble", "--voltage", "1.98", "--scale", "1", "--demands", str(tmp_path / "out")]
    refused = CliRunner().invoke(cli, words)
    assert refused.exit_code == 2
    assert "give it, such as --height 3m" in refused.output
    done = CliRunner().invoke(cli, [*words, "--height", "3m"], catch_exceptions=False)
    assert done.exit_code == 0
    assert "demands_damper.csv: 1 realisation of damper" in done.stderr
    both = CliRunner().invoke(cli, [*words, "--height", "3m", "--limit", "1%", "--json"], catch_exceptions=False)
    assert both.exit_code == 0
