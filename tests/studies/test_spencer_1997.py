"""The prototype of 1997: loops beside a Radau on the sources' letters, and predictions of records whose error is known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import dampyr as dp
from dampyr.records.datasets import data_set
from dampyr.studies import spencer_1997 as study

# the source's letters: spencer_1997_baig
C0, C1, ALPHA = (784.0, 1803.0), (14649.0, 34622.0), (12441.0, 38430.0)
K0, K1, X0, GAMMA, BETA, A, ETA = 3610.0, 840.0, 0.0245, 136320.0, 2059020.0, 58.0, 190.0
OFFSET, NOISE = -45.0, 150.0  # N


def largest_by_radau(voltage):
    """The largest force of the last two of five cycles, as the source computes it: from the lower end of the stroke."""
    omega = 2 * np.pi * study.FAST_FREQUENCY

    def motion(t):
        phase = omega * t - np.pi / 2
        return study.FAST_AMPLITUDE * np.sin(phase), study.FAST_AMPLITUDE * omega * np.cos(phase)

    def rates(t, s):
        y, z, u = s
        x, v = motion(t)
        c0, c1, alpha = (a + b * u for a, b in (C0, C1, ALPHA))
        dy = (alpha * z + c0 * v + K0 * (x - y)) / (c0 + c1)
        w = v - dy
        return np.array([dy, A * w - BETA * w * abs(z) ** 2 - GAMMA * abs(w) * z * abs(z), -ETA * (u - voltage)])

    end = 5 / study.FAST_FREQUENCY
    t = np.linspace(0.6 * end, end, 1001)
    states = solve_ivp(rates, (0, end), np.zeros(3), t_eval=t, method="Radau", rtol=1e-6, atol=1e-9).y.T
    force = [
        (C1[0] + C1[1] * s[2]) * rates(instant, s)[0] + K1 * (motion(instant)[0] - X0)
        for instant, s in zip(t, states, strict=True)
    ]
    return max(force)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return study.reproduce(tmp_path_factory.mktemp("without the records"))


def test_all_loops_agree_and_records_that_are_not_here_are_named(run):
    loops = [value for value in run.compared if value.artefact != study.RECORDS]
    assert len(loops) == 22
    assert {value.verdict for value in loops} == {"agrees"}
    unchecked = [value for value in run.compared if value.artefact == study.RECORDS]
    assert len(unchecked) == 6
    assert {value.verdict for value in unchecked} == {"cannot be checked"}
    assert "dampyr datasets fetch nees_2012_1158" in run.left_out[-1]
    assert "could be read" in run.left_out[0]


@pytest.mark.parametrize("voltage", list(study.LARGEST))
def test_the_source_states_the_largest_force_and_not_the_largest_size_of_it(voltage, run):
    by_radau = largest_by_radau(voltage)
    assert round(by_radau) == study.LARGEST[voltage]
    [ours] = [value.ours for value in run.compared if value.quantity == f"largest force, {voltage:g} V"]
    assert ours == pytest.approx(by_radau, rel=0.005)


def written(folder, x0=14.3):
    """Records of the prototype as the published copies have them: the set's own force, an error of known mean and variance."""
    about = dp.models.published.about(study.PROTOTYPE)
    damper = replace(about, printed={**about.printed, "x0": (x0, "cm")}).damper()
    folder.mkdir()
    rng = np.random.default_rng(4)
    (folder / "reading.toml").write_text(data_set(study.DATA).reading, encoding="utf-8")
    for k, file in enumerate(data_set(study.DATA).contents):
        t = np.arange(9000) / 3000.0
        x = sum(0.004 * np.sin(2 * np.pi * f * t + k) for f in (1.7, 3.1, 4.3))
        v = np.gradient(x, t)
        u = 1.1 + 1.1 * np.sign(np.sin(2 * np.pi * (8.0 + k) * t))
        force = damper.force(t, x, voltage=u, velocity=v) + OFFSET + NOISE * rng.standard_normal(t.size)
        columns = np.column_stack([t, 100 * x, 100 * v, force, u])
        rows = "\n".join(",".join(f"{value:.8g}" for value in row) for row in columns)
        (folder / file.name).write_text(f"t,D,V,F,Y\n{rows}\n", encoding="utf-8")
    return folder


def test_what_is_predicted_of_records_is_what_was_put_into_them(tmp_path):
    """R2 of a force with noise of a known variance, its mean, and that A, x0 and the lag are told apart."""
    run = study.reproduce(written(tmp_path / study.DATA))
    ours = {value.quantity: value.ours for value in run.compared if value.artefact == study.RECORDS}
    assert ours["mean error"] == pytest.approx(OFFSET, abs=8.0)
    assert ours["mean error without x0"] == pytest.approx(OFFSET - 71.5, abs=8.0)
    records = dp.records.read_campaign(tmp_path / study.DATA)
    kept = [record.force[record.time >= record.time[0] + study.SETTLING] for record in records]
    known = sorted(1.0 - (NOISE**2 + OFFSET**2) / force.var() for force in kept)
    assert ours["R² of the record predicted worst"] == pytest.approx(known[0], abs=0.01)
    assert ours["R² of the record predicted best"] == pytest.approx(known[1], abs=0.01)
    assert ours["R² with A = 58"] < known[0] - 0.05
    assert ours["R² without the command lag"] < known[0] - 0.05
    assert "nees" not in " ".join(run.left_out)
