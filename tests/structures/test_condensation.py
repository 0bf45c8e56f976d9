import warnings

import numpy as np
import pytest
from scipy.linalg import eigh

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.structures import Building, condense, respond, shear_building

MOTION = GroundMotion(np.asarray(el_centro().acceleration)[:201], 0.02, "start of El Centro")
LOWER, UPPER = np.array([300e3, 220e3]), np.array([200e3, 180e3])  # springs below and above a joint in each storey
MASSES = np.array([150.0, 120.0])


def chain(springs: np.ndarray) -> np.ndarray:
    n = len(springs)
    drift = np.eye(n) - np.eye(n, k=-1)
    return drift.T @ np.diag(springs) @ drift


def jointed(mass_of_joints: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two floors (2 and 4) with a joint half way up each storey (1 and 3)."""
    springs = np.ravel(np.column_stack([LOWER, UPPER]))
    M = np.diag([mass_of_joints, MASSES[0], mass_of_joints, MASSES[1]])
    return M, np.diag([0.0, 90.0, 0.0, 60.0]), chain(springs)


def test_joints_without_mass_are_springs_in_series():
    made = condense(*jointed(), keep=[2, 4])
    series = LOWER * UPPER / (LOWER + UPPER)
    assert made.exact
    np.testing.assert_allclose(made.K, chain(series), rtol=1e-12)
    np.testing.assert_allclose(made.M, np.diag(MASSES))
    np.testing.assert_allclose(made.C, np.diag([90.0, 60.0]))
    assert made.influence == pytest.approx([1.0, 1.0])
    assert made.floors == ("2", "4")
    assert made.frequency_errors == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_motion_of_what_was_left_out_is_recovered(cubics):
    made = condense(*jointed(), keep=["b", "d"], floors=("a", "b", "c", "d"))
    plain = Building(np.diag(MASSES), np.diag([90.0, 60.0]), chain(LOWER * UPPER / (LOWER + UPPER)))
    response = respond(made, MOTION, {("b", "d"): cubics}, voltage=0.0, step=0.002)
    expected = respond(plain, MOTION, {2: cubics}, voltage=0.0, step=0.002)
    assert response.displacement == pytest.approx(expected.displacement, abs=1e-12)
    everything = made.recover(response.displacement)
    first, second = response.displacement
    assert everything[[1, 3]] == pytest.approx(response.displacement, abs=0)
    assert everything[0] == pytest.approx(first * UPPER[0] / (LOWER[0] + UPPER[0]), abs=1e-15)
    between = (LOWER[1] * first + UPPER[1] * second) / (LOWER[1] + UPPER[1])
    assert everything[2] == pytest.approx(between, abs=1e-15)


def test_what_has_mass_is_condensed_with_its_error_told():
    M, C, K = jointed(mass_of_joints=30.0)
    with pytest.warns(DampyrWarning, match=r"has mass, so the condensed building is not exact: frequency 1 rises by"):
        made = condense(M, C, K, keep=[2, 4])
    whole = np.sqrt(eigh(K, M, eigvals_only=True))[:2]
    ours = np.sqrt(eigh(made.K, made.M, eigvals_only=True))
    assert not made.exact
    assert made.frequency_errors == pytest.approx(ours / whole - 1.0, rel=1e-6)
    assert np.all(made.frequency_errors > 1e-4)  # Guyan's frequencies are upper bounds


def test_under_a_steady_push_condensation_is_exact_even_with_mass():
    """M' iota' is the whole push, so the floors lean as far as those of the whole."""
    M, C, K = jointed(mass_of_joints=30.0)
    with pytest.warns(DampyrWarning):
        made = condense(M, C, K, keep=[2, 4])
    leaning = np.linalg.solve(made.K, made.M @ made.influence)
    assert leaning == pytest.approx(np.linalg.solve(K, M @ np.ones(4))[[1, 3]], rel=1e-10)


def test_dashpots_on_what_is_left_out_are_told_too():
    M, C, K = jointed()
    C[0, 0] = 40.0
    with pytest.warns(DampyrWarning, match=r"has mass and damping"):
        made = condense(M, C, K, keep=[2, 4])
    assert made.C[0, 0] == pytest.approx(90.0 + 40.0 * (UPPER[0] / (LOWER[0] + UPPER[0])) ** 2)


def test_a_building_is_condensed_by_label_or_count(cubics):
    tall = shear_building([1000.0] * 6, [2e6] * 6, damping_ratio=0.02)
    with pytest.warns(DampyrWarning, match=r"frequency 1 rises by"):
        small = tall.condensed(keep=["2", 4, "6"])
    assert small.floors == ("2", "4", "6")
    assert small.T.shape == (6, 3)
    assert small.frequencies[0] == pytest.approx(tall.frequencies[0], rel=0.02)
    with pytest.raises(InputError, match=r"floor '3' is not in .* label: 2, 4, 6"):
        small.connection(("2", "3"))


def test_all_kept_in_another_order_is_the_same_building():
    tall = shear_building([100.0, 200.0, 300.0], [3e5, 2e5, 1e5], damping_ratio=0.02)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        turned = tall.condensed(keep=[3, 1, 2])
    assert turned.exact
    assert turned.frequencies == pytest.approx(tall.frequencies)
    assert np.diag(turned.M).tolist() == [300.0, 100.0, 200.0]


@pytest.mark.parametrize(
    ("keep", "message"),
    [
        ([2, 5], r"floor 5 is not in building; .* up to 4"),
        ([], r"keep = \[\] is not allowed"),
        ([2, 2], r"keep = \[2, 2\] is not allowed; give different floors"),
        ([0, 2], r"the ground not among them"),
        ([1, 2], r"M has the eigenvalue 0"),
    ],
)
def test_what_cannot_be_kept(keep, message):
    M, C, K = jointed()
    with pytest.raises(InputError, match=message):
        condense(M, C, K, keep)


def test_what_no_spring_holds_cannot_be_left_out():
    M, C, K = jointed()
    K[0, :] = K[:, 0] = 0.0
    with pytest.raises(InputError, match=r"left out \(1, 3\) is not held by springs"):
        condense(M, C, K, keep=[2, 4])


def test_a_building_without_mass_somewhere_names_the_way():
    with pytest.raises(InputError, match=r"M has the eigenvalue 0.*condense\(M, C, K, keep\)"):
        Building(*jointed())
