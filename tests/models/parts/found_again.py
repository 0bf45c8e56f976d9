"""Six sines of a known damper without noise, and what a fit finds of its numbers."""

from collections.abc import Mapping

from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.records import Record

MOTIONS = ((0.002, 0.5), (0.005, 0.5), (0.01, 0.5), (0.003, 2.0), (0.006, 2.0), (0.01, 2.0))  # m, Hz


def damper(name: str, numbers: Mapping[str, float]) -> Damper:
    return Damper(name, {f"{name}.{key}": value for key, value in numbers.items()})


def six_sines(one: Damper) -> list[Record]:
    return [sine(one, 0.0, f"{1e3 * a:g} mm {f:g} Hz", amplitude=a, frequency=f) for a, f in MOTIONS]


def assert_found_again(name: str, numbers: Mapping[str, float]) -> None:
    """Each number within 1 %, and every record to an L1 of 0.1 %."""
    result = fit(six_sines(damper(name, numbers)), name)
    assert result.converged, result.reason
    for key, value in numbers.items():
        got = result.parameters[f"{name}.{key}"]
        assert abs(got - value) <= 0.01 * abs(value), (key, got, value)
    assert max(score.l1 for score in result.scores.values()) < 1e-3
