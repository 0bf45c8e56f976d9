"""Tables of cycles against closed forms (Dahl, bilinear, power law, generalised Maxwell) and the shoelace on real loops."""

import json
from math import isnan, pi, tanh
from pathlib import Path

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import InputError
from dampyr.records import Record, cycles
from dampyr.records.cycle_analysis.device_figures import power_law_energy
from dampyr.show import write_page
from dampyr.to_json import plain

D, F = 0.010, 0.5
W = 2 * pi * F
WITHIN = 2e-3


def motion(samples: int = 40, count: int = 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, displacement and velocity of a sine, with so many samples a cycle."""
    t = np.arange(count * samples + 1) / samples / F
    return t, D * np.sin(W * t), D * W * np.cos(W * t)


def sampled(model: str, values: dict[str, float], samples: int = 40, **about: object) -> Record:
    """A record of a damper, computed on fifty times finer steps than it is sampled."""
    t, x, v = motion(50 * samples)
    force = dp.models.Damper(model, values).force(t, x, velocity=v)
    stride = slice(None, None, 50)
    return Record(t[stride], x[stride], np.asarray(force)[stride], **({"no_input": True} | about))  # type: ignore[arg-type]


@pytest.mark.parametrize("samples", [40, 200])
def test_a_bilinear_device(samples: int) -> None:
    q, uy, k2 = 900.0, 0.001, 1e5
    figures = cycles(sampled("bilinear", {"Q": q, "uy": uy, "k2": k2}, samples))[0]
    assert figures.device == "displacement"
    assert [cycle.in_level for cycle in figures.cycles] == [1, 2, 3, 4]
    for cycle in figures.cycles[1:]:
        energy, stiffness = 4 * q * (D - uy), q / D + k2
        assert cycle.energy == pytest.approx(energy, rel=WITHIN)
        assert cycle.effective_stiffness == pytest.approx(stiffness, rel=WITHIN)
        assert cycle.damping_ratio == pytest.approx(energy / (2 * pi * stiffness * D**2), rel=WITHIN)
        assert cycle.characteristic_strength == pytest.approx(q, rel=WITHIN)
        assert cycle.second_slope == pytest.approx(k2, rel=WITHIN)
        assert cycle.loss_stiffness == pytest.approx(energy / (pi * D**2), rel=5 * WITHIN)  # a corner between samples
    assert figures.cycles[0].characteristic_strength == pytest.approx(q, rel=WITHIN)  # not that of rest


def test_a_dahl_device() -> None:
    kw, rho = 300.0, 600.0
    cycle = cycles(sampled("dahl", {"kx": 0.0, "kw": kw, "rho": rho}))[0].cycles[-1]
    energy = 4 * kw * (D - tanh(rho * D) / rho)
    assert cycle.energy == pytest.approx(energy, rel=WITHIN)
    assert cycle.effective_stiffness == pytest.approx(kw * tanh(rho * D) / D, rel=WITHIN)
    assert cycle.damping_ratio == pytest.approx(energy / (2 * pi * kw * tanh(rho * D) * D), rel=WITHIN)
    at_middle = kw * (1.0 - (1.0 + tanh(rho * D)) * np.exp(-rho * D))
    assert (cycle.zero_out, -cycle.zero_in) == pytest.approx((at_middle, at_middle), rel=WITHIN)
    assert cycle.loss_stiffness == pytest.approx(energy / (pi * D**2), rel=WITHIN)


@pytest.mark.parametrize("alpha", [0.3, 1.0])
def test_a_viscous_device_has_no_equivalent_damping(alpha: float) -> None:
    c = 1000.0
    result = cycles(sampled("power_law", {"C": c, "alpha": alpha}))
    figures = result[0]
    assert figures.device == "viscous"
    for cycle in figures.cycles[1:]:
        assert cycle.energy == pytest.approx(power_law_energy(c * (D * W) ** alpha, D, alpha), rel=WITHIN)
        assert cycle.largest_force == pytest.approx(c * (D * W) ** alpha, rel=WITHIN)
        assert [figures.figure(cycle, name) for name in ("damping_ratio", "loss_factor", "second_slope")] == [None] * 3
        if alpha == 1.0:
            assert figures.figure(cycle, "viscous_coefficient") == pytest.approx(c, rel=WITHIN)
    assert result.as_dict()["records"][0]["cycles"][2]["damping_ratio"] is None


def test_an_elastomer_has_storage_stiffness_and_loss_factor_of_its_arms() -> None:
    k0, arms, tau = 1e5, (5e4, 5e4, 3e4), 0.05
    values = {"k0": k0, "tau": tau} | {f"k{i}": k for i, k in enumerate(arms, 1)}
    turns = [W * tau * 10**i for i in range(3)]
    storage = k0 + sum(k * wt**2 / (1 + wt**2) for k, wt in zip(arms, turns, strict=True))
    loss = sum(k * wt / (1 + wt**2) for k, wt in zip(arms, turns, strict=True))
    t, x, v = motion(2000, 30)  # the slowest arm forgets where it began within 5 s
    force = np.asarray(dp.models.Damper("generalised_maxwell", values).force(t, x, velocity=v))
    cycle = cycles(Record(t[::50], x[::50], force[::50], no_input=True))[0].cycles[-1]
    assert cycle.storage_stiffness == pytest.approx(storage, rel=WITHIN)
    assert cycle.effective_stiffness == pytest.approx(storage, rel=WITHIN)
    assert cycle.loss_stiffness == pytest.approx(loss, rel=WITHIN)
    assert cycle.loss_factor == pytest.approx(loss / storage, rel=WITHIN)
    assert cycle.energy == pytest.approx(pi * loss * D**2, rel=WITHIN)
    assert cycle.damping_ratio == pytest.approx(0.5 * loss / storage, rel=WITHIN)
    assert cycle.dynamic_stiffness == pytest.approx(np.hypot(storage, loss), rel=WITHIN)


def test_a_device_with_an_input_is_switched_and_another_kind_is_asked_for_by_name() -> None:
    record = sampled("dahl", {"kx": 0.0, "kw": 300.0, "rho": 600.0}, no_input=False, voltage=1.0)
    figures = cycles(record)[0]
    assert (figures.device, figures.setting) == ("switched", "1 V")
    assert figures.figure(figures.cycles[2], "damping_ratio") is None
    assert figures.figure(figures.cycles[2], "characteristic_strength") == pytest.approx(298.5, rel=WITHIN)
    asked = cycles(record, device="displacement")[0]
    assert asked.figure(asked.cycles[2], "damping_ratio") == pytest.approx(0.5305, rel=WITHIN)
    viscous = cycles(sampled("power_law", {"C": 1000.0, "alpha": 1.0}), device="displacement")
    assert "an equivalent damping tells nothing" in viscous.findings[0].words
    with pytest.raises(InputError, match="device"):
        cycles(record, device="magnetic")
    with pytest.raises(InputError, match="needs a record"):
        cycles([])


def test_fade_is_told_against_the_third_cycle_from_the_start() -> None:
    t, x, v = motion(400, 6)
    fading = 1.0 - 0.04 * np.minimum(np.floor(t * F), 5)
    figures = cycles(Record(t, x, 2000.0 * fading * v, no_input=True))[0]
    fades = [figures.fade(cycle, "energy") for cycle in figures.cycles]
    assert fades == pytest.approx([(1 - 0.04 * k) / 0.92 - 1 for k in range(6)], abs=2e-3)
    two = cycles(Record(t[:801], x[:801], 2000.0 * v[:801], no_input=True))[0]
    assert [two.fade(cycle, "energy") for cycle in two.cycles] == [None, None]


LEVELS = (0.002, 0.004, 0.006, 0.008, 0.010)


def rising(offset: float = 0.0) -> Record:
    """Two cycles of each level of a bilinear device, and a quarter of one more to 12 mm, where it stops; 80 samples a cycle."""
    n = 4000
    phase = np.arange(10 * n + n // 4 + 1) / n
    x = np.take((*LEVELS, 0.012), np.minimum(np.floor(phase / 2).astype(int), 5)) * np.sin(2 * pi * phase)
    t = 2.0 * phase
    force = dp.models.Damper("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5}).force(t, x, velocity=np.gradient(x, t))
    return Record(t[::50], x[::50], np.asarray(force)[::50] + offset, no_input=True)


@pytest.mark.parametrize("offset", [0.0, 200.0])
def test_a_rising_protocol_has_half_cycles_a_backbone_and_sums(offset: float) -> None:
    figures = cycles(rising(offset))[0]
    assert [level.cycles for level in figures.levels] == [2] * 5
    assert len(figures.half_cycles) == 20
    for half in figures.half_cycles[2:]:
        amplitude = LEVELS[(half.number - 1) // 4]
        assert abs(half.displacement) == pytest.approx(amplitude, rel=1e-9)
        assert half.extension == (half.number % 2 == 1)
        assert abs(half.force_at_displacement - offset) == pytest.approx(900.0 + 1e5 * amplitude, rel=WITHIN)
        assert half.energy == pytest.approx(2 * 900.0 * (amplitude - 0.001), rel=5 * WITHIN)
    ends = [-a for a in LEVELS[::-1]] + [*LEVELS, 0.012]
    np.testing.assert_allclose(figures.backbone[:, 0], ends, rtol=1e-9)
    np.testing.assert_allclose(
        figures.backbone[:, 1], [np.sign(a) * 900.0 + 1e5 * a + offset for a in ends], rtol=WITHIN
    )
    assert figures.travel[-1] == pytest.approx(sum(8 * a for a in LEVELS), rel=1e-9)
    assert figures.whole_travel == pytest.approx(figures.travel[-1] + 0.012, rel=1e-9)
    energy = sum(8 * 900.0 * (a - 0.001) for a in LEVELS)  # less what the first quarter of all lacks: 0.45 J
    assert figures.total_energy[-1] == pytest.approx(energy - 0.45, rel=WITHIN)


def test_noise_and_the_steps_of_an_encoder_add_no_travel() -> None:
    t, x, v = motion(4000, 3)
    rough = 2e-5 * np.round((x + np.random.default_rng(1).normal(0, 1.5e-5, t.size)) / 2e-5)
    assert float(np.sum(np.abs(np.diff(rough)))) > 0.2
    assert cycles(Record(t, rough, 2000.0 * v, no_input=True))[0].whole_travel == pytest.approx(12 * D, rel=1e-2)


def at_speed(speed: float, voltage: float, stroke: float = 0.02, gas: float = 112.0) -> Record:
    """A sine of a damper with (100 + 300 u) N and 2000 N s/m outwards, half of that inwards, and a gas force."""
    f = speed / (pi * stroke)
    t = np.arange(0.0, 5.0 / f, 1.0 / (400 * f))
    v = speed * np.cos(2 * pi * f * t)
    force = np.where(v > 0, 1.0, 0.5) * (2000.0 * v + (100.0 + 300.0 * voltage) * np.tanh(v / (0.01 * speed))) + gas
    return Record(
        t, 0.5 * stroke * np.sin(2 * pi * f * t), force, voltage=voltage, specimen="SN 1", name=f"{speed}-{voltage}"
    )


SPEEDS = (0.05, 0.10, 0.20)


def test_force_and_speed_asymmetry_and_dynamic_range() -> None:
    records = [at_speed(speed, voltage) for voltage in (0.0, 1.0, 2.0) for speed in SPEEDS]
    result = cycles(records, speeds=(0.08, 0.15, 0.5), gas_force="112 N")
    measured = result.measured_speeds
    assert [(point.setting, round(point.speed, 2)) for point in measured[:3]] == [
        ("0 V", 0.05),
        ("0 V", 0.10),
        ("0 V", 0.20),
    ]
    pick_up = 0.983  # the mean speed above 95 % of its peak
    assert measured[1].extension == pytest.approx(112.0 + 100.0 + 2000.0 * 0.1 * pick_up, rel=5e-3)
    assert measured[1].compression == pytest.approx(112.0 - 0.5 * (100.0 + 2000.0 * 0.1 * pick_up), rel=5e-3)
    assert all(point.ratio == pytest.approx(2.0, rel=5e-3) for point in measured)
    low, high, beyond = result.standard_speeds[:3]
    assert low.extension == pytest.approx(112.0 + 100.0 + 2000.0 * 0.08 * pick_up, rel=5e-3)
    assert high.extension == pytest.approx(112.0 + 100.0 + 2000.0 * 0.15 * pick_up, rel=5e-3)
    assert (beyond.extension, beyond.compression, beyond.ratio) == (None, None, None)
    rows = [force for force in result.settings if force.direction == "extension" and force.speed == 0.08]
    forces = [100.0 + 300.0 * u + 2000.0 * 0.08 * pick_up for u in (0.0, 1.0, 2.0)]
    assert [force.force for force in rows] == pytest.approx(forces, rel=5e-3)
    assert [force.share for force in rows] == pytest.approx([0.0, 0.5, 1.0], abs=5e-3)
    assert rows[-1].dynamic_range == pytest.approx(forces[2] / forces[0], rel=5e-3)
    assert not [force for force in result.settings if force.speed == 0.5]


def test_without_a_gas_force_there_is_no_asymmetry_and_the_range_is_that_of_both_directions() -> None:
    result = cycles([at_speed(speed, voltage, gas=400.0) for voltage in (0.0, 2.0) for speed in SPEEDS], speeds=(0.1,))
    assert {point.ratio for point in result.measured_speeds} == {None}
    soft, hard = result.settings
    assert (soft.direction, hard.direction) == ("both", "both")
    assert soft.force == pytest.approx(0.75 * (100.0 + 2000.0 * 0.0983), rel=5e-3)
    assert hard.dynamic_range == pytest.approx((700.0 + 196.6) / (100.0 + 196.6), rel=5e-3)


def test_an_input_that_changes_nothing_has_no_share(tmp_path: Path) -> None:
    passive = [at_speed(speed, 1.0) for speed in SPEEDS]
    other = [record.replace(note="another voltage", voltage=2.0, name=f"{record.name} b") for record in passive]
    result = cycles([*passive, *other], speeds=(0.1,))
    assert [(force.dynamic_range, isnan(force.share)) for force in result.settings] == [(1.0, True)] * 2
    assert "NaN" not in json.dumps(plain(result.as_dict()))
    assert "dynamic range" in write_page(result, tmp_path / "page.html").read_text("utf-8")


def test_an_input_that_is_measured_counts_as_constant_where_it_is_but_for_noise() -> None:
    noise = np.random.default_rng(1)
    records = [at_speed(speed, 2.0) for speed in SPEEDS]
    measured = [r.replace(note="measured", voltage=2.0 + noise.normal(0.0, 0.01, r.n)) for r in records]
    assert len({point.setting for point in cycles(measured).measured_speeds}) == 1


def test_the_gas_force_of_a_record_of_rests_is_taken_for_its_specimen() -> None:
    t = np.arange(0.0, 32.0, 0.01)
    places = 0.004 * np.array([0, 1, 2, 1, 0, -1, -2, -1, 0])
    edges = np.repeat(places, 2)
    at = np.repeat(np.arange(9) * 3.5, 2) + np.tile([0.0, 3.0], 9)
    x = np.interp(t, at, edges)
    hold = np.sign(np.gradient(x))
    for k in range(1, t.size):
        hold[k] = hold[k] or hold[k - 1]
    rests = Record(t, x, 112.0 + 20.0 * hold, voltage=0.0, specimen="SN 1", name="rests")
    result = cycles([rests, at_speed(0.1, 0.0)])
    assert result.gas_forces == {"SN 1": pytest.approx(112.0, abs=0.5)}
    assert result[0].cycles == ()
    assert "rests: it gives a gas force of 112 N" in result.findings[-1].words
    assert [point.ratio for point in result.measured_speeds] == [pytest.approx(2.0, rel=1e-2)]


def test_a_step_of_the_input_has_t63_and_t90_of_its_lag_and_none_below_the_noise() -> None:
    t = np.arange(0.0, 3.0, 5e-4)
    x = 0.03 * (1.0 - np.abs(t - 1.0)) * (t < 2.0)  # a triangle: constant speed out, and back
    voltage = np.where((t > 0.5) & (t < 1.5), 2.0, 0.0)
    lagged = np.where(t < 0.5, 0.0, 1.0 - np.exp(-(t - 0.5) / 0.02))
    way = np.where(t < 1.0, 1.0, -1.0)
    force = way * (100.0 + 400.0 * lagged)
    keep = t < 1.0
    record = Record(t[keep], x[keep], force[keep], voltage=voltage[keep])
    assert cycles(record)[0].setting == ""
    (switch,) = cycles(record)[0].switches
    assert (switch.t63, switch.t90) == pytest.approx((0.02, 0.02 * np.log(10.0)), rel=0.03)
    small = force + np.random.default_rng(1).normal(0.0, 200.0, t.size)
    (lost,) = cycles(Record(t[keep], x[keep], small[keep], voltage=voltage[keep]))[0].switches
    assert lost.t63 is None
    assert "5 sigma" in lost.reason


def test_a_record_without_a_cycle_says_so_and_has_its_sums() -> None:
    t = np.linspace(0.0, 1.0, 100)
    result = cycles(Record(t, 0.01 * t, 5.0 * t, no_input=True))
    assert result[0].cycles == ()
    assert result[0].whole_travel == pytest.approx(0.01)
    assert "no full cycle" in result.findings[-1].words


def test_units_of_tables_and_axes() -> None:
    record = sampled("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5})
    from dampyr.show.records.cycle_figures import cycle_table, overlay

    heads = {system: cycle_table(cycles(record, unit_system=system)) for system in ("SI", "mm-N", "in-lb")}
    column = {system: dict(zip(table.heads, table.rows[2], strict=True)) for system, table in heads.items()}
    assert column["SI"]["stroke [m]"] == pytest.approx(0.02)
    assert column["mm-N"]["effective stiffness [N/mm]"] == pytest.approx(190.0, rel=WITHIN)
    assert column["in-lb"]["effective stiffness [lbf/in]"] == pytest.approx(1084.93, rel=WITHIN)
    assert column["in-lb"]["energy [in lbf]"] == pytest.approx(32.4 * 8.850746, rel=WITHIN)
    drawn = overlay(cycles(record, unit_system="in-lb"))
    assert drawn is not None
    assert [panel.get_xlabel() for panel in drawn.axes] == ["displacement [in]", "velocity [in/s]"]
    assert drawn.axes[0].lines[0].get_xdata().max() == pytest.approx(0.01 / 0.0254, rel=1e-3)


def test_a_data_frame_has_a_row_for_each_cycle_in_si() -> None:
    frame = cycles([sampled("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5})] * 2).to_dataframe()
    assert len(frame) == 8
    assert frame["energy_J"].iloc[2] == pytest.approx(32.4, rel=WITHIN)


@pytest.mark.parametrize("name", ["ensaio1.1", "ensaio5.2.2", "ensaio.A.3", "ensaio.vali.1"])
def test_energies_of_real_loops_are_those_of_the_shoelace(name: str, campaign_folder: Path) -> None:
    record = dp.records.read(campaign_folder / f"{name}.mat", voltage=1.0)
    figures = cycles(record)[0]
    assert len(figures.cycles) >= 5
    for cycle in figures.cycles:
        x, force = figures.loop(cycle)
        area = 0.5 * float(np.sum(x[:-1] * force[1:] - x[1:] * force[:-1]) + x[-1] * force[0] - x[0] * force[-1])
        assert cycle.energy == pytest.approx(abs(area), rel=WITHIN)


def test_a_record_that_ends_a_sample_early_has_its_last_cycle_closed() -> None:
    t, x, v = motion(200, 3)
    whole, short = (cycles(Record(t[:n], x[:n], 50.0 + 2000.0 * v[:n], no_input=True))[0] for n in (t.size, t.size - 1))
    assert [len(figures.cycles) for figures in (whole, short)] == [3, 3]
    assert short.cycles[2].energy == pytest.approx(whole.cycles[2].energy, rel=WITHIN)
    assert short.cycles[2].zero_out == pytest.approx(50.0 + 2000.0 * D * W, rel=WITHIN)
