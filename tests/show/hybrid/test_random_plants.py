"""What virtual hybrid tests on random plants show: medians and the worst of each criterion."""

import numpy as np
import pytest

from dampyr.hybrid.criteria import CRITERIA
from dampyr.hybrid.random_plants import PLANT, BatchResult
from dampyr.show.descriptions import description_of

N = 5
TRUE = np.arange(1.0, 1.0 + N * len(CRITERIA)).reshape(N, len(CRITERIA))
TRUE[2, CRITERIA.index("J2")] = 90.0
PLANTS = np.arange(float(N * len(PLANT))).reshape(N, len(PLANT))


@pytest.fixture
def batch() -> BatchResult:
    flags = np.zeros(N, dtype=bool)
    return BatchResult("frame", PLANTS, TRUE, 2.0 * TRUE[:, :5], np.full(N, 0.5), flags, flags)


def test_the_worst_plant_is_named_with_its_numbers(batch: BatchResult) -> None:
    rows = dict(description_of(batch).rows)
    assert rows["plants"] == str(N)
    values = TRUE[:, CRITERIA.index("J2")]
    where = ", ".join(f"{name} {value:.4g}" for name, value in zip(PLANT, PLANTS[2], strict=True))
    assert rows["J2"] == f"median {np.median(values):.3g} %, worst 90 % at {where}"


def test_a_row_of_the_table_holds_median_95_per_cent_and_worst(batch: BatchResult) -> None:
    [table] = [make() for make in description_of(batch).tables]
    for k, row in enumerate(table.rows):
        ordered = np.sort(TRUE[:, k])
        nearly = ordered[-2] + 0.8 * (ordered[-1] - ordered[-2])  # the 95 % quantile of five is at 3.8 of 0 to 4
        assert list(row) == [
            CRITERIA[k],
            pytest.approx(ordered[2]),
            pytest.approx(nearly),
            ordered[-1],
            int(np.argmax(TRUE[:, k])),
        ]


def test_the_frame_holds_plants_true_and_measured_criteria(batch: BatchResult) -> None:
    frame = batch.to_dataframe()
    np.testing.assert_array_equal(frame[list(PLANT)], PLANTS)
    np.testing.assert_array_equal(frame[f"{CRITERIA[0]}_measured"], 2.0 * TRUE[:, 0])
