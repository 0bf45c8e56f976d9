import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.structures import Building, shear_building, state_space, two_storey


def test_two_storey_is_the_published_building_in_si():
    building = two_storey()
    assert building.frequencies == pytest.approx([2.0856, 5.4603], abs=5e-5)
    assert building.damping_ratios == pytest.approx([0.030, 0.030], abs=5e-5)
    assert np.asarray(building.M)[0, 0] == pytest.approx(145.8)
    assert building.floors == ("1", "2")


def test_two_storey_damping_is_rayleigh():
    building = two_storey()
    fit, residual, *_ = np.linalg.lstsq(
        np.column_stack([building.M.ravel(), building.K.ravel()]), building.C.ravel(), rcond=None
    )
    assert fit == pytest.approx([0.5686, 0.001266], rel=1e-3)
    assert np.sqrt(residual[0]) < 1e-3 * np.linalg.norm(building.C)


def test_matrices_are_copies_and_read_only():
    mass = np.eye(2)
    building = Building(mass, 0 * np.eye(2), np.eye(2))
    mass[0, 0] = 7.0
    assert building.M[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        building.M[0, 0] = 3.0


def test_shear_building_stacks_springs():
    building = shear_building([1.0, 2.0, 3.0], [10.0, 20.0, 40.0], dashpots=[1.0, 0.0, 0.0])
    assert building.K.tolist() == [[30.0, -20.0, 0.0], [-20.0, 60.0, -40.0], [0.0, -40.0, 40.0]]
    assert building.C.tolist() == [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]


def test_uniform_shear_building_has_the_closed_form_frequencies():
    n, k, m = 6, 4e5, 700.0
    expected = np.sqrt(k / m) / np.pi * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1)))
    assert shear_building([m] * n, [k] * n, damping_ratio=0.0).frequencies == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("method", ["rayleigh", "modal"])
def test_damping_ratio_is_met(method):
    building = shear_building([1.0, 2.0, 3.0], [10.0, 20.0, 40.0], damping_ratio=0.05, method=method)
    ratios = building.damping_ratios
    assert ratios[:2] == pytest.approx([0.05, 0.05], rel=1e-9)
    assert (ratios[2] == pytest.approx(0.05, rel=1e-9)) == (method == "modal")


def test_one_storey_with_a_ratio():
    building = shear_building([2.0], [50.0], damping_ratio=0.05)
    assert building.C[0, 0] == pytest.approx(2 * 0.05 * 5.0 * 2.0)


def test_a_free_mode_has_no_damping_ratio_but_is_allowed():
    building = Building(np.eye(2), np.zeros((2, 2)), [[1.0, -1.0], [-1.0, 1.0]])
    assert building.frequencies[0] == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(building.damping_ratios[0])


def test_connection_of_a_storey():
    building = shear_building([1.0] * 3, [1.0] * 3, damping_ratio=0.0)
    assert building.connection(1).tolist() == [1.0, 0.0, 0.0]
    assert building.connection(3).tolist() == [0.0, -1.0, 1.0]


def test_state_space_has_the_sign_that_the_equation_of_motion_asks_for():
    building = two_storey()
    model = state_space(building, 1)
    assert model.connection.ravel().tolist() == [-1.0, 0.0]
    rng = np.random.default_rng(5)
    x, f, ground = rng.normal(size=4), rng.normal(size=1), rng.normal()
    relative = np.linalg.solve(
        building.M,
        -building.M @ [1, 1] * ground + model.connection @ f - building.C @ x[2:] - building.K @ x[:2],
    )
    assert (model.A @ x + model.B @ f + model.E * ground)[2:] == pytest.approx(relative)
    assert model.C @ x + model.D @ f == pytest.approx(relative + ground)
    assert np.array_equal(model.D, model.B[2:])  # (5.6) prints the other sign


def test_state_space_of_two_dampers():
    model = state_space(two_storey(), [1, 2])
    assert model.connection.tolist() == [[-1.0, 1.0], [0.0, -1.0]]
    assert model.B.shape == (4, 2)


EYE = np.eye(2)


@pytest.mark.parametrize(
    ("matrices", "message"),
    [
        ((np.ones((2, 3)), EYE, EYE), r"M has shape \(2, 3\); it must be square"),
        ((EYE, EYE, np.eye(3)), r"differ in size \(M 2x2, C 2x2, K 3x3\)"),
        ((EYE, EYE, [[1.0, 0.5], [0.2, 1.0]]), r"K is not symmetric: .* 0.3"),
        ((np.diag([1.0, 0.0]), EYE, EYE), r"M has the eigenvalue 0; .* greater than 0"),
        ((EYE, EYE, np.diag([1.0, -2.0])), r"K has the eigenvalue -2; .* at least 0"),
        ((EYE, np.diag([-1.0, 1.0]), EYE), r"C has the eigenvalue -1; .* at least 0"),
        ((EYE, EYE, np.diag([1.0, np.nan])), r"K holds values that are not finite"),
    ],
)
def test_bad_matrices_are_refused(matrices, message):
    with pytest.raises(InputError, match=message):
        Building(*matrices)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"masses": [1.0], "stiffnesses": [1.0, 2.0], "damping_ratio": 0.0}, r"1 masses and 2 stiffnesses"),
        (
            {"masses": [1.0, -1.0], "stiffnesses": [1.0, 2.0], "damping_ratio": 0.0},
            r"masses = .* greater than 0",
        ),
        ({"masses": [1.0], "stiffnesses": [1.0]}, r"either damping_ratio= or dashpots="),
        ({"masses": [1.0], "stiffnesses": [1.0], "damping_ratio": 3.0}, r"damping_ratio = 3 .* below 1"),
        (
            {"masses": [1.0], "stiffnesses": [1.0], "damping_ratio": 0.03, "method": "caughey"},
            r"'rayleigh' or 'modal'",
        ),
        ({"masses": [1.0], "stiffnesses": [1.0], "dashpots": [-1.0]}, r"dashpots = .* at least 0"),
    ],
)
def test_bad_shear_buildings_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        shear_building(**arguments)


@pytest.mark.parametrize("storey", [0, 3, 1.5, True])
def test_a_storey_that_is_not_there_is_refused(storey):
    with pytest.raises(InputError, match=r"storey .* is not in .* to 2"):
        two_storey().connection(storey)


def test_floor_labels_must_fit():
    with pytest.raises(InputError, match=r"does not label 2 floors"):
        Building(EYE, EYE, EYE, floors=["a"])
    with pytest.raises(InputError, match=r"influence has shape"):
        Building(EYE, EYE, EYE, influence=[1.0])
