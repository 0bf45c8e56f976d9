"""The extension of a Bouc-Wen element in series with a dashpot, beside a bracketed root of its equation."""

import numpy as np
import pytest
from scipy.optimize import brentq

from dampyr.models.numerics.bouc_wen_exact import flow
from dampyr.models.parts import _series


def test_the_extension_meets_its_equation_with_few_flows(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = [0]

    def counted(*given: float) -> float:
        counts[0] += 1
        return flow(*given)

    monkeypatch.setattr(_series, "flow", counted)
    rng, cases = np.random.default_rng(0), 400
    for _ in range(cases):
        y, delta, beta = rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-3.0, 1.0), 10.0 ** rng.uniform(-2.0, 0.5)
        n, c = rng.uniform(1.0, 4.0), 2.0 * 10.0 ** rng.uniform(-1.0, 1.0) - 1.0
        near = _series.extension(y, delta, beta, n, c)

        def excess(xi: float, y=y, delta=delta, beta=beta, n=n, c=c) -> float:
            return xi + beta * ((y + 4.0 * flow(y, 0.5 * xi, n, c) + flow(y, xi, n, c)) / 6.0 - y) - delta

        exact = brentq(excess, 0.0, delta, xtol=1e-300, rtol=1e-14)
        assert near == pytest.approx(exact, rel=1e-6)
    assert (
        counts[0] / cases < 5.0
    )  # 8.6 where Newton's method began at 0 and took each state from the start of the step
