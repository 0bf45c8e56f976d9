"""The derivatives of a part's states are those of its own step along a path, as the step goes to 0."""

import numpy as np
import pytest
from tests.invariants.test_every_part import typical

from dampyr.errors import InputError
from dampyr.models import available_parts, compose
from dampyr.models.codegen.rates import check_has_rates, functions, switch_texts
from dampyr.models.part import part

WITH_RATES = [name for name in available_parts() if part(name).rates]
WITHOUT = {
    "bilinear": "held at stops",
    "choi_polynomial": "follow the change of the velocity",
    "compliance": "root of an equation",
    "delay": "the force of a time ago",
    "free_play": "root of an equation",
    "hysteretic_biviscous": "follow the change of the velocity",
    "inertia": "needs the acceleration",
    "maxwell_slip": "held at stops",
    "shutting_bleed": "held at stops",
    "sigmoid": "follow the change of the velocity",
    "triple_pendulum": "held at stops",
}


@pytest.mark.parametrize("name", WITH_RATES)
def test_rates_are_the_step_over_a_short_time(name: str) -> None:
    """At 40 drawn states, places and velocities of both signs, by a central estimate from two steps, to 1e-5 of the largest."""
    it, values = part(name), {key.split(".")[1]: value for key, value in typical(name).items()}
    draws = np.random.default_rng(3)
    found, expected = [], []
    for _ in range(40):
        s = [float(draws.uniform(-0.8, 0.8)) * (5e-4 if high == np.inf else 1.0) for _, high in it.states.values()]
        if name == "bouc_wen_baber_noori":
            s[1] = abs(s[1])  # the energy taken
        x, v = float(draws.uniform(-0.01, 0.01)), float(draws.choice([-1.0, 1.0]) * draws.uniform(0.02, 0.3))
        motion = {"x": x, "v": v} | dict(zip(it.states, s, strict=True)) | values
        assert it.rates is not None
        found.append(np.atleast_1d(it.module.rates(**{key: motion[key] for key in it.rates.arguments})))
        slopes = []
        for dt in (2e-7, 1e-7):
            step = {"x0": x, "x1": x + v * dt, "v0": v, "v1": v, "dt": dt}
            assert it.advance is not None
            end = it.module.advance(**{key: (motion | step)[key] for key in it.advance.arguments})
            slopes.append((np.atleast_1d(end) - np.array(s)) / dt)
        expected.append(2.0 * slopes[1] - slopes[0])  # without the error of first order
    scale = np.max(np.abs(expected), axis=0)
    np.testing.assert_allclose(np.array(found) / scale, np.array(expected) / scale, rtol=0.0, atol=1e-5)


def test_every_part_has_rates_or_a_reason() -> None:
    plain = {name for name in available_parts() if not part(name).states} - set(WITHOUT)
    assert set(WITH_RATES) | set(WITHOUT) | plain == set(available_parts())
    for name, reason in WITHOUT.items():
        with pytest.raises(InputError, match=f"{name} is no differential equation for a solver: it .*{reason}"):
            check_has_rates(compose(f"dahl + {name}"))
    check_has_rates(compose("dahl + spring + offset + lag"))


def test_switches_are_written_once_over_the_vectors() -> None:
    """Dahl, Bouc-Wen and asymmetric Bouc-Wen turn round together."""
    assert switch_texts(compose("dahl + bouc_wen + asymmetric_bouc_wen")) == ["v", "x"]
    assert switch_texts(compose("spring + modified_bouc_wen")) == ["v - p[3] * (s[0] + p[5] * s[1])"]
    assert switch_texts(compose("spring + bingham")) == []
    named = {each.name: each.body for each in functions(compose("bouc_wen + generalised_maxwell"))}
    assert named["rates"] == [
        "rate[0] = bouc_wen_rates(s[0], v, p[3], p[4], p[5])",
        "rate[1], rate[2], rate[3] = generalised_maxwell_rates(s[1], s[2], s[3], v, p[10])",
        "return",
    ]
