"""The published sets against their own equations, in their own units and letters, and against what their sources state."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from dampyr import ground_motions, structures
from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Damper, published
from dampyr.models.published._conversion import ratio

Array = NDArray[np.float64]
PER_METRE = {"m": 1.0, "cm": 100.0, "mm": 1000.0}  # printed lengths in a metre
STEPS = 4000


def made(name: str, *without: str) -> Damper:
    """The damper less some parts."""
    return published.damper(name).without(*without)


def sine(name: str, cycles: int = 3) -> tuple[Array, Array, Array]:
    """The motion of the source in SI: t, x, v."""
    motion = published.about(name).motion
    t = np.arange(cycles * STEPS + 1) / (STEPS * motion.frequency)
    omega = 2.0 * np.pi * motion.frequency
    return t, motion.amplitude * np.sin(omega * t), motion.amplitude * omega * np.cos(omega * t)


def force(name: str, u: float, cycles: int = 3) -> Array:
    t, x, v = sine(name, cycles)
    given = {"voltage": u} if published.about(name).input == "V" else {"current": u}
    return made(name).force(t, x, velocity=v, **given)


def spencer(p: dict[str, float], u: float) -> tuple[Callable, Callable]:
    """(rates of z and y, force) of Spencer et al. (1997), gamma with |v|."""
    alpha, c0, c1 = (p[f"{a}a"] + p[f"{a}b"] * u for a in ("alpha_", "c0", "c1"))

    def rates(x: float, v: float, z: float, y: float) -> list[float]:
        dy = (alpha * z + c0 * v + p["k0"] * (x - y)) / (c0 + c1)
        w = v - dy
        loss = p["gamma"] * abs(w) * z * abs(z) ** (p["n"] - 1) + p["beta"] * w * abs(z) ** p["n"]
        return [p["A"] * w - loss, dy]

    def total(x: Array, v: Array, z: Array, y: Array) -> Array:
        return c1 * (alpha * z + c0 * v + p["k0"] * (x - y)) / (c0 + c1) + p["k1"] * (x - p["x0"])

    return rates, total


def eldorado(p: dict[str, float], i: float) -> tuple[Callable, Callable]:
    """The same with cubics in the current, beta with |v|, no k1 and a constant force."""
    alpha, c0, c1 = (sum(p[f"{a}_{k}"] * i**k for k in range(4)) for a in ("alpha", "c0", "c1"))

    def dy(x: float, v: float, z: float, y: float) -> float:
        return (1 / (c0 + c1)) * (alpha * z + c0 * v + p["k0"] * (x - y))

    def rates(x: float, v: float, z: float, y: float) -> list[float]:
        w = v - dy(x, v, z, y)
        first = -p["beta"] * abs(w) * z * abs(z) ** (p["nbw"] - 1)
        return [first - p["gama"] * w * abs(z) ** p["nbw"] + p["A"] * w, dy(x, v, z, y)]

    return rates, lambda x, v, z, y: c1 * dy(x, v, z, y) + p["f0"]


def simple(p: dict[str, float], u: float) -> tuple[Callable, Callable]:
    """F = c0 v + alpha z; y is not used."""
    alpha, c0 = p["alpha_a"] + p["alpha_b"] * u, p["c0a"] + p["c0b"] * u

    def rates(x: float, v: float, z: float, y: float) -> list[float]:
        return [p["A"] * v - p["gamma"] * abs(v) * z - p["beta"] * v * abs(z), 0.0]

    return rates, lambda x, v, z, y: alpha * z + c0 * v


OWN_LETTERS = {"eldorado_as_noted": eldorado, "eldorado_as_run": eldorado}
FAMILY = {"bouc_wen": simple, "modified_bouc_wen": spencer}


def equations(name: str) -> Callable:
    """The published equations of a set: those of its model, unless it has letters of its own."""
    return OWN_LETTERS.get(name, FAMILY[published.about(name).model])


def by_the_book(name: str, u: float, cycles: int) -> Array:
    """The force in N by scipy from the published equations, lengths in the printed unit."""
    about = published.about(name)
    scale = PER_METRE[about.length]
    rates, total = equations(name)(about.numbers, u)
    t, x, v = sine(name, cycles)
    a, omega = scale * about.motion.amplitude, 2.0 * np.pi * about.motion.frequency
    done = solve_ivp(
        lambda s, q: rates(a * np.sin(omega * s), a * omega * np.cos(omega * s), *q),
        (0.0, t[-1]),
        [0.0, 0.0],
        t_eval=t,
        max_step=t[2],
        rtol=1e-8,
        atol=1e-10,
    )
    return np.asarray(total(scale * x, scale * v, *done.y))


@pytest.mark.prove
@pytest.mark.parametrize("name", published.available_sets())
@pytest.mark.parametrize("which", [0, -1])
def test_the_force_is_that_of_the_published_equations(name: str, which: int) -> None:
    u = published.about(name).motion.inputs[which]
    ours, theirs = force(name, u, 1), by_the_book(name, u, 1)
    assert np.abs(ours - theirs).max() < 1e-3 * np.abs(theirs).max()
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 5e-5 * np.abs(theirs).max()


@pytest.mark.prove
@pytest.mark.parametrize("name", published.available_sets())
def test_between_the_knots_of_its_laws_too(name: str) -> None:
    low, high = published.about(name).limits
    u = low + 0.37123 * (high - low)
    ours, theirs = force(name, u, 1), by_the_book(name, u, 1)
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 5e-5 * np.abs(theirs).max()


@pytest.mark.parametrize("name", [n for n in published.available_sets() if equations(n) is not simple])
@pytest.mark.parametrize("inputs", [112, pytest.param(333, marks=pytest.mark.prove)])
def test_a_ratio_of_laws_is_right_to_a_ten_thousandth(name: str, inputs: int) -> None:
    damper, p = made(name), published.about(name).numbers
    z_max = np.sqrt(p["A"] / (p["beta"] + p.get("gamma", p.get("gama"))))
    for u in np.linspace(*damper.range, inputs):
        if equations(name) is eldorado:
            alpha, c0, c1 = (sum(p[f"{a}_{k}"] * u**k for k in range(4)) for a in ("alpha", "c0", "c1"))
        else:
            alpha, c0, c1 = (p[f"{a}a"] + p[f"{a}b"] * u for a in ("alpha_", "c0", "c1"))
        at = dict(zip(damper.composition.parameters, damper.values(u), strict=True))
        scale = PER_METRE[published.about(name).length]
        assert at["modified_bouc_wen.vc"] * scale == pytest.approx(alpha * z_max / c1, rel=1e-4)
        assert at["modified_bouc_wen.r"] == pytest.approx(c0 / c1, rel=1e-4)
        assert at["modified_bouc_wen.kappa"] / scale == pytest.approx(p["k0"] / (alpha * z_max), rel=1e-4)
        assert at["modified_bouc_wen.kw"] == pytest.approx(alpha * z_max, rel=1e-12)


WITH_ETA = [name for name in published.available_sets() if published.about(name).eta is not None]


@pytest.mark.prove
@pytest.mark.parametrize("name", WITH_ETA)
def test_a_step_of_the_command_is_followed_by_one_less_an_exponential(name: str) -> None:
    """The force is that of the damper without the lag whose input goes as V (1 - exp(-eta t)) after the step."""
    eta, (low, high) = published.about(name).eta, published.about(name).limits
    damper = made(name)
    t, x, v = sine(name, 1)
    t0 = t[STEPS // 3]
    command = np.where(t >= t0, high, low)
    late = np.maximum(t - t0 + 0.5 * t[1], 0.0)  # the command rises along one sample, in its middle on average
    followed = low + (high - low) * -np.expm1(-eta * late)
    ours = damper.force(t, x, voltage=command, velocity=v)
    theirs, at_once = (made(name, "lag").force(t, x, voltage=u, velocity=v) for u in (followed, command))
    assert np.abs(ours - theirs).max() < 2e-3 * np.ptp(theirs)
    assert np.abs(ours - at_once).max() > 0.2 * np.ptp(theirs)


@pytest.mark.prove
@pytest.mark.parametrize("name", WITH_ETA)
def test_a_changing_command_gives_the_force_of_the_published_equations_with_their_filter(name: str) -> None:
    about = published.about(name)
    scale = PER_METRE[about.length]
    family, (low, high) = equations(name), about.limits
    t, x, v = sine(name, 1)
    a, omega = scale * about.motion.amplitude, 2.0 * np.pi * about.motion.frequency

    def command(s: Array | float) -> Array:
        return np.asarray(0.5 * (low + high) + 0.5 * (high - low) * np.sin(4.7 * omega * s))

    def rates(s: float, q: Array) -> list[float]:
        z, y, u = q
        own, _ = family(about.numbers, u)
        return [*own(a * np.sin(omega * s), a * omega * np.cos(omega * s), z, y), -about.eta * (u - command(s))]

    done = solve_ivp(
        rates, (0.0, t[-1]), [0.0, 0.0, float(command(0.0))], t_eval=t, max_step=t[2], rtol=1e-8, atol=1e-10
    )
    z, y, u = done.y
    theirs = family(about.numbers, u)[1](scale * x, scale * v, z, y)
    ours = made(name).force(t, x, voltage=command(t), velocity=v)
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 2e-4 * np.abs(theirs).max()


@pytest.mark.prove
@pytest.mark.parametrize("name", WITH_ETA)
def test_a_constant_command_lags_behind_nothing(name: str) -> None:
    t, x, v = sine(name, 1)
    u, damper = published.about(name).limits[1], made(name)
    ours, theirs = (one.force(t, x, voltage=u, velocity=v) for one in (damper, made(name, "lag")))
    np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_allclose(damper.force(t, x, voltage=np.full(t.size, u), velocity=v), theirs, rtol=1e-12)


LAW = partial(structures.control_law, "on_off", low=0.0, high=2.25)


def test_a_control_law_with_a_lag_of_its_own_and_an_inverse_in_c_refuse_it(tmp_path: Path) -> None:
    motion, building = ground_motions.el_centro().scaled(0.05), structures.two_storey()
    with pytest.raises(InputError, match="leave one of the two out"):
        structures.respond(building, motion, {1: made("spencer_1997")}, voltage=LAW(lag=1.0 / 190.0))
    words = r"export damper.without\('lag'\), or with --without lag, .* u' = \(u_c - u\)/0.00526316 s"
    with pytest.raises(InputError, match=words):
        export(made("spencer_1997"), "c", tmp_path, inverse=True)
    assert export(made("spencer_1997"), "c", tmp_path)


@pytest.mark.by_hand  # two kernels of half a minute each; the lag itself is a proof above
def test_the_lag_of_a_modified_bouc_wen_damper_is_that_of_a_law_with_the_same_lag() -> None:
    whole, building = ground_motions.el_centro().scaled(0.05), structures.two_storey()
    motion = ground_motions.GroundMotion(whole.acceleration[:101], whole.dt, "the first 2 s")
    ours = structures.respond(building, motion, {1: made("spencer_1997")}, voltage=LAW())
    theirs = structures.respond(building, motion, {1: made("spencer_1997", "lag")}, voltage=LAW(lag=1.0 / 190.0))
    np.testing.assert_allclose(ours.peak_displacement, theirs.peak_displacement, rtol=1e-9)


@pytest.mark.by_hand  # as above
@pytest.mark.filterwarnings("ignore:the damper in storey .* fed")  # its spring is switched with the voltage
def test_its_lag_under_a_control_law_is_that_of_a_law_with_the_same_lag() -> None:
    whole, building = ground_motions.el_centro().scaled(0.05), structures.two_storey()
    motion = ground_motions.GroundMotion(whole.acceleration[:301], whole.dt, "the first 6 s")
    name, law = "tan_agrawal_2004", partial(structures.control_law, "on_off", low=0.0, high=10.0)
    small, bare = made(name).at_level(1e-3), made(name, "lag").at_level(1e-3)  # of 1 kN, for the building of the model
    ours = structures.respond(building, motion, {1: small}, voltage=law())
    theirs = structures.respond(building, motion, {1: bare}, voltage=law(lag=1.0 / published.about(name).eta))
    np.testing.assert_allclose(ours.peak_displacement, theirs.peak_displacement, rtol=1e-9)


def test_ratio_of_two_straight_lines() -> None:
    law = ratio([1.0, 2.0], [4.0, 0.5], (0.0, 2.0))
    assert (law.low, law.high) == (0.0, 2.0)
    assert law(1.3) == pytest.approx((1.0 + 2.6) / (4.0 + 0.65), rel=1e-5)


BY_HAND = {  # at one input, from the printed numbers with pencil and paper
    # z_max = sqrt(301/726) = 0.64390 cm; kw = (140 + 695) 0.64390 = 537.65 N; vc = 537.65/285.95 = 1.8802 cm/s
    "spencer_1997": (1.0, {"kw": 537.65, "k1": 500.0, "vc": 0.018802, "r": 24.5 / 285.95, "rho": 46746.5, "f0": -71.5}),
    # z_max = sqrt(58/7.26e6) = 2.82649 mm; kw = 83500 N/m 2.82649 mm = 236.01 N; vc = 236.01/28595 m/s
    "spencer_1997_damper_lab": (1.0, {"kw": 236.01, "k1": 500.0, "vc": 0.0082536, "r": 2450 / 28595, "rho": 20520.1}),
    # z_max = sqrt(58/2195340) = 5.13998 mm; kw = 50871 N/m 5.13998 mm = 261.48 N; vc = 261.48/49271 m/s
    "spencer_1997_baig": (1.0, {"kw": 261.48, "k1": 840.0, "vc": 0.0053070, "sigma": 0.062095, "f0": -20.58}),
    # z_max = 1.2/600 = 2 mm; kw = (1.0872e7 + 5 4.9616e7) 0.002 = 517904 N; c0 = 440 + 22000 N s/m
    "tan_agrawal_2004": (5.0, {"kw": 517904.0, "c0": 22440.0, "rho": 600.0, "sigma": 0.5, "n": 1.0}),
    # kw = (1087200 + 5 4691600) 0.002 = 49090.4 N; c0 = 44 + 2200 N s/m
    "azimi_2020": (5.0, {"kw": 49090.4, "c0": 2244.0, "rho": 600.0, "sigma": 0.5, "n": 1.0}),
    # z_max = sqrt(10.013/3.147) = 1.78373 mm; alpha = 38.24 + 206.26 + 226.285 - 103.334 = 367.451 N/mm; kw = 655.43 N
    # c0 = 0.59 + 5.51 + 2.6275 - 1.46625 = 7.26125; c1 = 4.73 + 32.285 + 14.2575 - 6.8 = 44.4725 N s/mm
    "eldorado_as_noted": (
        0.5,
        {"kw": 655.43, "vc": 0.014738, "r": 0.163275, "sigma": 0.967270, "rho": 5613.5, "f0": 40.0},
    ),
    "eldorado_as_run": (
        0.5,
        {"kw": 655.43, "vc": 0.014738, "r": 0.163275, "sigma": 0.032730, "rho": 5613.5, "f0": 40.0},
    ),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_the_conversion_by_hand(name: str) -> None:
    u, expected = BY_HAND[name]
    damper = made(name)
    at = {
        flat.split(".")[1]: value for flat, value in zip(damper.composition.parameters, damper.values(u), strict=True)
    }
    assert {key: at[key] for key in expected} == pytest.approx(expected, rel=2e-4)


def last_cycle(name: str, u: float) -> tuple[Array, float]:
    """The force of the third cycle and what it dissipates, J."""
    t, _, v = sine(name)
    f = force(name, u)
    s = slice(-STEPS - 1, None)
    return f[s], float(np.trapezoid(f[s] * v[s], t[s]))


@pytest.mark.prove
def test_the_peaks_that_the_readme_of_baig_states() -> None:
    """8 mm at 10 Hz: 414 N at 0 V and 2511 N at 2 V (README of MRD-Modified-Bouc-Wen-Model)."""
    assert last_cycle("spencer_1997_baig", 0.0)[0].max() == pytest.approx(414.0, rel=5e-3)
    assert last_cycle("spencer_1997_baig", 2.0)[0].max() == pytest.approx(2511.0, rel=5e-3)


@pytest.mark.prove
def test_what_the_readme_of_the_damper_lab_states() -> None:
    """15 mm at 1.5 Hz and 1 V: +544.0, -545.5 N and 27.963 J per cycle, by the README of MR-Damper-Lab."""
    f, work = last_cycle("spencer_1997_damper_lab", 1.0)
    assert f.max() == pytest.approx(544.0, rel=5e-3)
    assert f.min() == pytest.approx(-545.5, rel=5e-3)
    assert work == pytest.approx(27.963, rel=1e-2)


def test_the_capacities_that_the_sources_state() -> None:
    """1000 kN at 10 V (Max_for, Umax) and 50 kN at 5 V (Fmax, Vmax): the hysteretic force alone, and 5 % with the dashpot."""
    for name, u, capacity in (("tan_agrawal_2004", 10.0, 1000e3), ("azimi_2020", 5.0, 50e3)):
        assert made(name).at(u)[0].kw == pytest.approx(capacity, rel=0.02)
        assert last_cycle(name, u)[0].max() == pytest.approx(capacity, rel=0.05)


def test_the_a_of_the_damper_lab_scales_the_hysteretic_force() -> None:
    ratio_of_kw = made("spencer_1997_damper_lab").at(1.0)[0].kw / made("spencer_1997").at(1.0)[0].kw
    assert ratio_of_kw == pytest.approx(np.sqrt(58 / 301), rel=1e-12)


def test_the_page_is_what_the_sets_say() -> None:
    root = Path(__file__).resolve().parents[2]
    page = (root / "docs" / "reference" / "published.md").read_text(encoding="utf-8")
    for name in published.available_sets():
        section = page.partition(f"## `{name}`\n")[2].partition("\n## ")[0]
        for letter, (number, unit) in published.about(name).printed.items():
            assert f"| `{letter}` | {number:.15g} | {unit} |" in section
