"""The force along a sampled path: inputs that vary, a delay, parts that add up; wrong paths and starts are refused."""

import numpy as np
import pytest
from tests.models.dahl_of_chapter_4 import T, V, X, published

from dampyr.errors import InputError
from dampyr.models import Damper


def test_a_voltage_that_does_not_vary_is_the_same_as_a_number() -> None:
    damper = published()
    one = damper.force(T, X, voltage=1.5, velocity=V)
    np.testing.assert_array_equal(damper.force(T, X, voltage=np.full(T.size, 1.5), velocity=V), one)


def test_a_voltage_that_steps_changes_the_force_at_once_and_the_state_along_the_path() -> None:
    damper = published()
    u = np.where(T < 1.0, 0.0, 3.0)
    force = damper.force(T, X, voltage=u, velocity=V)
    np.testing.assert_allclose(force[T < 1.0], damper.force(T, X, voltage=0.0, velocity=V)[T < 1.0])
    late = damper.force(T, X, voltage=3.0, velocity=V)
    np.testing.assert_allclose(force[-200:], late[-200:], rtol=1e-6)


def test_a_delay_shifts_the_whole_force() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 9000.0}
    plain = Damper("dahl", laws).force(T, X, voltage=0.0, velocity=V)
    late = Damper("dahl + delay", laws | {"delay.tau": 0.020}).force(T, X, voltage=0.0, velocity=V)
    np.testing.assert_allclose(late[10:], plain[:-10], rtol=1e-9)
    np.testing.assert_allclose(late[:10], plain[0])


@pytest.mark.parametrize(
    ("t", "x", "words"),
    [
        (T, X[:-1], "same length"),
        (T[::-1], X, "t must rise"),
        (T, np.where(T > 1.0, np.nan, X), "finite"),
        (T.reshape(7, -1), X.reshape(7, -1), "two vectors"),
    ],
)
def test_a_wrong_path_is_refused(t: np.ndarray, x: np.ndarray, words: str) -> None:
    with pytest.raises(InputError, match=words):
        published().force(t, x, voltage=0.0)


def test_a_wrong_initial_state_is_refused() -> None:
    with pytest.raises(InputError, match=r"dahl\.w = 1\.5 must lie between -1 and 1"):
        published().force(T, X, voltage=0.0, state0=[1.5])
    with pytest.raises(InputError, match="has 2 values"):
        published().force(T, X, voltage=0.0, state0=[0.0, 0.0])
