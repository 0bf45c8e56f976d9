"""J1 to J9 against their definitions, in plain numpy."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.hybrid.criteria import tracking_criteria

DT = 1.0 / 4096.0


def histories(delay: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(20000) * DT
    floors = np.array([np.sin(20 * t) * np.exp(-0.1 * t), 1.5 * np.sin(20 * t), 2 * np.sin(20 * t + 0.1)])
    reference = 1.02 * floors + 0.01 * np.cos(50 * t)
    late = np.concatenate([np.zeros(delay), floors[0, : len(t) - delay]])
    return 0.98 * late + 0.002 * np.cos(90 * t), floors, reference


@pytest.mark.parametrize("delay", [0, 7, 49])
def test_they_are_their_definitions(delay: int) -> None:
    x, floors, reference = histories(delay)
    J = tracking_criteria(x, floors[0], floors, reference, 1, DT)
    n = len(x)
    correlations = [np.corrcoef(x[k:], floors[0, : n - k])[0, 1] for k in range(50)]
    assert pytest.approx(1e3 * DT * int(np.argmax(correlations)), rel=1e-12) == J.J1
    assert pytest.approx(1e3 * DT * delay, abs=1e3 * DT) == J.J1

    def spread(a: np.ndarray, b: np.ndarray) -> float:
        return float(100 * np.std(a - b) / np.std(b))

    def peak(a: np.ndarray, b: np.ndarray) -> float:
        return float(100 * np.max(np.abs(a - b)) / np.max(np.abs(b)))

    expected = [spread(x, floors[0]), peak(x, floors[0]), spread(x, reference[0]), peak(x, reference[0])]
    expected += [spread(floors[k], reference[k]) for k in (1, 2)] + [peak(floors[k], reference[k]) for k in (1, 2)]
    np.testing.assert_allclose(J[1:], expected, rtol=1e-12)


def test_a_structure_of_fewer_floors_has_fewer() -> None:
    x, floors, reference = histories(3)
    one = tracking_criteria(x, floors[0], floors[:1], reference[:1], 1, DT)
    two = tracking_criteria(x, floors[0], floors[:2], reference[:2], 1, DT)
    assert np.isnan(one[5:]).all()
    assert np.isnan([two.J7, two.J9]).all()
    assert two.J6 > 0.0


def test_what_cannot_be_compared_is_refused() -> None:
    x, floors, reference = histories(0)
    with pytest.raises(InputError, match="do not match"):
        tracking_criteria(x[:-1], floors[0], floors, reference, 1, DT)
    with pytest.raises(InputError, match="50 samples are too few"):
        tracking_criteria(x[:50], floors[0, :50], floors[:, :50], reference[:, :50], 1, DT)
    with pytest.raises(InputError, match="nothing moves"):
        tracking_criteria(x, 0 * floors[0], floors, reference, 1, DT)
