"""What benches count and search for, on problems whose answer is known."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dampyr import registry

ROOT = Path(__file__).resolve().parents[1]
SOURCE = """def integrate_block(first, last, parts, ground, times, c, b):
    scale = c[0]*times[0]
    for i in range(first, last):
        for l in range(64):
            x, y = b[0 + l], b[64 + l]
            low = x*y + scale
            twice = y*x*one
            unused = x/y
            b[0 + l] = low + zero
            b[64 + l] = min(twice - low, exp(zero*x))
"""


def bench(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A module of the benches."""
    from importlib import import_module

    monkeypatch.syspath_prepend(str(ROOT))
    return import_module(f"benchmarks.{name}")


def test_operations_are_counted_once_and_only_if_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """x*y, + scale and the difference; the exponential of 0 is a number of all histories."""
    operations = bench("_operations", monkeypatch)
    engine = SimpleNamespace(text=SimpleNamespace(source=SOURCE, block_width=64), compositions=())
    assert operations.total(engine) == 3
    assert operations.per_step(engine)["min"] == 1


def test_bits_and_signs_cost_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    operations = bench("_operations", monkeypatch)
    source = SOURCE.replace("low + zero", "copysign(x, y)").replace(
        "min(twice - low, exp(zero*x))", "whole(real(x).view(whole) + 7).view(real)"
    )
    engine = SimpleNamespace(text=SimpleNamespace(source=source, block_width=64), compositions=())
    assert operations.total(engine) == 0
    assert operations.per_step(engine)["+ of whole numbers"] == 1


def test_the_longest_step_within_the_error_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A contender of first order whose worst case has an error of 0.06/m needs 60 steps; they are found to an eighth."""
    suite = bench("_suite", monkeypatch)
    true = np.linspace(1.0, 2.0, 42).reshape(21, 2)
    sizes = np.linspace(0.01, 0.06, 21)
    cases = [SimpleNamespace(dt=0.02, k=k) for k in range(21)]
    monkeypatch.setattr(suite, "reference", lambda: true)
    monkeypatch.setattr(suite, "suite", lambda: cases)

    def peaks(these: list[Any], m: int) -> Any:
        return np.array([true[case.k] * (1.0 + sizes[case.k] / m) for case in these])

    m, worst_error = suite.coarsest(peaks)
    assert 60 <= m <= 67
    assert worst_error.floor == pytest.approx(0.06 / m)
    assert suite.coarsest(lambda these, m: np.full((len(these), 2), np.nan))[1].floor == np.inf


def test_long_benches_wait_to_be_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    main = bench("__main__", monkeypatch)
    assert "million" in registry.names("benchmarks")
    assert "million" not in main.usual()
    assert {"ensemble", "core", "storeys", "parts", "workers", "opensees"} <= set(main.usual())


def test_a_contender_that_did_not_run_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = bench("_lines", monkeypatch)
    shown = lines.show([lines.Line("a", 1.0, 1.0, 3), lines.Line("b: missing", float("nan"), float("nan"), 0)])
    assert shown.splitlines()[-1].strip() == "b: missing"


@pytest.mark.prove
def test_the_runge_kutta_that_a_user_writes_has_the_peaks_of_the_ensemble(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the middle of the scales: in single ones a decision may fall the other way."""
    controlled = bench("controlled_histories", monkeypatch)
    monkeypatch.setattr(controlled, "FEW", controlled.FEW[::4])
    monkeypatch.setattr(controlled, "SCALES", controlled.FEW)
    law = controlled.LAWS["clipped-optimal, ideal sensing"]
    with ThreadPoolExecutor(1) as one:
        peaks = controlled.side_by_side(one, law, "strict").dataset.isel(building=0, damper=0, input=0, motion=0)
    ours = np.stack([peaks.displacement[:, 0], peaks.drift[:, 1], peaks.force[:, 0]], axis=1)
    off = np.abs(ours / controlled.by_hand(80) - 1.0)
    assert np.all(np.median(off, axis=0) < 2e-3)
    alone = controlled.scalar(law, 16)()
    np.testing.assert_allclose(alone["drift"], peaks.drift, rtol=1e-9)
