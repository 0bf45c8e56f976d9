"""Do 95 % intervals hold the truth in 95 of 100 campaigns?"""

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper, Interpolation
from dampyr.records import Record

CAMPAIGNS = 200
VOLTS = (0.0, 2.0)
LAWS = {
    "dahl.kx": Interpolation(VOLTS, (800.0, 2500.0)),
    "dahl.kw": Interpolation(VOLTS, (50.0, 380.0)),
    "dahl.rho": Interpolation(VOLTS, (4000.0, 1800.0)),
}


def campaign(seed: int, per_voltage: int) -> list[Record]:
    """Sines at two voltages with noise that is correlated over a third of a second, and another offset each."""
    rng = np.random.default_rng(seed)
    records = []
    for u in VOLTS:
        for k in range(per_voltage):
            amplitude, frequency = rng.uniform(0.004, 0.012), rng.uniform(0.6, 1.4)
            record = sine(Damper("dahl", LAWS), u, f"{u:g}V-{k}", amplitude, frequency, offset=rng.normal(100.0, 20.0))
            noise = lfilter([1.0], [1.0, -0.985], rng.normal(0.0, 0.02 * (50.0 + 165.0 * u), record.n + 400))[400:]
            records.append(record.replace(note="with correlated noise", force=record.force + noise))
    return records


@pytest.mark.prove
@pytest.mark.parametrize("per_voltage", [8, 10])
def test_intervals_hold_the_truth_as_often_as_they_say(per_voltage: int) -> None:
    truth = np.concatenate([law.values for law in LAWS.values()])
    held, naive = np.zeros(truth.size), np.zeros(truth.size)
    for seed in range(CAMPAIGNS):
        found = fit("dahl", campaign(seed, per_voltage))
        assert found.clusters == "record"
        values = np.array(list(found.parameters.values()))
        spans = np.array(list(found.intervals(0.95).values()))
        held += (spans[:, 0] <= truth) & (truth <= spans[:, 1])
        naive += np.abs(values - truth) <= 1.96 * np.array(list(found.naive_stderr.values()))
    shares = 100 * held / CAMPAIGNS
    print("intervals", shares, "naive", 100 * naive / CAMPAIGNS)
    assert np.all((shares >= 91.0) & (shares <= 98.0)), shares
    assert np.min(naive) < 0.8 * CAMPAIGNS
