# The equations of docs/reference/models.md, solved as in series_march.py by bracketed roots and by an implicit march.
"""Every part of the catalogue behind every element in series, and delayed, on random paths of 10 mm and of 5 um.

What the sampled path determines is compared with the rule that models.md states, to 1e-9 at any step; the rest with the
equations themselves, which it must approach at the order that its page states. The short tests run the generated functions as
plain Python, so that nothing is compiled.
"""

import math
import warnings
from itertools import pairwise

import numpy as np
import pytest
from tests.models.plain_kernels import run_as_plain_python
from tests.references.series_march import (
    EQUATIONS,
    NO_FORCE,
    NO_MEMORY,
    Equation,
    Series,
    Site,
    equation,
    implicit_rule,
    march,
    march_building,
)

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper, Polynomial, available_parts
from dampyr.models.codegen import series
from dampyr.models.part import part
from dampyr.structures import respond, shear_building

FULL, SMALL = 0.010, 5e-6  # m
LONG = {FULL: 1.0, SMALL: 0.1}  # s
RATES = {FULL: (3.0, 40.0), SMALL: (60.0, 600.0)}  # rad/s
# m/N; m, as large a part of the motion at both sizes; N. At rest the play is as soft as the compliance, or softer.
COMPLIANCE = Series(s=5e-7)
PLAY = {FULL: Series(g=5e-4, fc=100.0), SMALL: Series(g=5e-6, fc=3.0)}
NAMES = [name for name in available_parts() if name not in NO_FORCE]
SIZES = pytest.mark.parametrize("size", [FULL, SMALL], ids=["10mm", "5um"])
#: of what holds at both sizes the small one is in `make test`
SMALL_FIRST = pytest.mark.parametrize("size", [pytest.param(FULL, marks=pytest.mark.prove), SMALL], ids=["10mm", "5um"])
# The full size takes four times the samples; behind each element it is tried at every rate below too.
LONG_SIZES = pytest.mark.parametrize(
    "size", [pytest.param(FULL, marks=pytest.mark.by_hand), SMALL], ids=["10mm", "5um"]
)


def elements(size: float) -> dict[str, Series]:
    play = PLAY[size]
    return {
        "compliance": COMPLIANCE,
        "free play": play,
        "both": Series(COMPLIANCE.s, play.g, play.fc),
        "delay": Series(tau=0.0237 * LONG[size]),
        "all": Series(COMPLIANCE.s, play.g, play.fc, 0.0237 * LONG[size]),
    }


def reference_of(name: str, size: float) -> Equation:
    each = equation(name)
    assert each is not None
    return each.with_numbers(each.small) if size == SMALL else each


def motion(seed: int, size: float, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """t, x and v of six sines, grown from rest; ``at`` (n,) from 0 to 1 of its whole time."""
    rng = np.random.default_rng(seed)
    omega, phase, whole = rng.uniform(*RATES[size], 6), rng.uniform(0.0, 2 * np.pi, 6), LONG[size]

    def along(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q = np.minimum(t / (0.3 * whole), 1.0)
        grown, rate = q**3 * (10 - 15 * q + 6 * q * q), 30 * (q * (1 - q)) ** 2 / (0.3 * whole)
        x, v = np.sin(np.outer(t, omega) + phase) @ (1 / omega), np.cos(np.outer(t, omega) + phase).sum(axis=1)
        return grown * x, grown * v + rate * x

    scale = size / np.abs(along(np.linspace(0.0, whole, 4001))[0]).max()
    x, v = along(at * whole)
    return at * whole, scale * x, scale * v


def uneven(seed: int, n: int) -> np.ndarray:
    """Instants from 0 to 1 at random distances, up to ten times as far from one another here than there."""
    steps = np.random.default_rng(seed).uniform(0.2, 2.0, n)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


def regular(n: int) -> np.ndarray:
    return np.linspace(0.0, 1.0, n + 1)


def alternating(n: int) -> tuple[np.ndarray, np.ndarray]:
    """100 equal stretches of n/100 steps, every other one of twice as many; and which samples are their ends."""
    each = [n // 100 * (1 + k % 2) for k in range(100)]
    steps = np.repeat(0.01 / np.array(each), each)
    return np.concatenate([[0.0], np.cumsum(steps)]), np.concatenate([[0], np.cumsum(each)])


def damper(name: str, each: Equation, stands: Series, whole: bool = False) -> Damper:
    """The part with what stands in series with it; ``whole`` has all of that, some of it nothing, to be compiled once."""
    laws = {f"{name}.{key}": float(value) for key, value in each.values.items()}
    if part(name).needs_acceleration:  # it stands at the outer end, beside what is in series
        laws |= {f"spring.{key}": float(value) for key, value in EQUATIONS["spring"].values.items()}
    if stands.s or whole:
        laws |= {"compliance.s": stands.s}
    if stands.g or whole:
        laws |= {"free_play.g": stands.g, "free_play.fc": stands.fc}
    if stands.tau or whole:
        laws |= {"delay.tau": stands.tau}
    return Damper(list(dict.fromkeys(key.partition(".")[0] for key in laws)), laws)


def late(t: np.ndarray, force: np.ndarray, tau: float) -> np.ndarray:
    return np.interp(t - tau, t, force)


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernels as plain Python: the generated text and the drivers as they are written."""
    run_as_plain_python(monkeypatch)


def test_every_part_has_a_reference() -> None:
    """A new part is compared too, once its equations are written down: else this says where."""
    for name in available_parts():
        equation(name)
    assert set(EQUATIONS) == {name for name in available_parts() if part(name).force}


@pytest.mark.usefixtures("plain")
@SMALL_FIRST
@pytest.mark.parametrize("name", [name for name in NAMES if EQUATIONS.get(name, EQUATIONS["spring"]).exact])
def test_what_the_path_determines_follows_the_rule_at_any_step(name: str, size: float) -> None:
    each = reference_of(name, size)
    for seed, (_, stands) in enumerate(elements(size).items()):
        t, x, v = motion(seed, size, uneven(seed, 60))
        ours = damper(name, each, stands).force(t, x, voltage=0.0, velocity=v)
        exact = expected(name, each, stands, t, x, v)
        np.testing.assert_allclose(ours, exact, rtol=0.0, atol=1e-9 * np.abs(exact).max())


def expected(name: str, each: Equation, stands: Series, t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The rule of the part; of inertia that of the spring beside it, as its force needs the acceleration of the ends."""
    outer = np.zeros_like(t)
    if name == "inertia":
        outer, each = each.p[0] * np.gradient(v, t), EQUATIONS["spring"]
    force = implicit_rule(each, stands, t, x, v)
    if stands.s == stands.g == 0.0:
        force[0] = each.force(v[0], x[0], NO_MEMORY, each.p)  # a force that nothing stretches is no state
    return late(t, force + outer, stands.tau)


@pytest.mark.usefixtures("plain")
@SMALL_FIRST
@pytest.mark.parametrize("name", [name for name, each in EQUATIONS.items() if each.by_path is not None])
def test_without_a_dashpot_a_path_in_series_is_exact_at_any_step(name: str, size: float) -> None:
    """The same force at samples of a polygon as where its sides are cut into sixteen: no rate enters."""
    each = reference_of(name, size).with_numbers(EQUATIONS[name].by_path or {})
    if name == "inertia":
        each = each.with_numbers({"m": 0.0})
    t, x, v = motion(3, size, uneven(3, 40))
    fine = np.interp(np.arange(16 * 40 + 1) / 16, np.arange(41), t)
    for stands in (COMPLIANCE, PLAY[size]):
        ours = damper(name, each, stands).force(t, x, voltage=0.0, velocity=v)
        many = expected(name, each, stands, fine, np.interp(fine, t, x), np.zeros_like(fine))[::16]
        np.testing.assert_allclose(ours, many, rtol=0.0, atol=1e-9 * np.abs(many).max())


def errors_along(
    name: str, each: Equation, stands: Series, size: float, counts: list[int], fine: int, compiled: bool
) -> tuple[list[np.ndarray], np.ndarray]:
    """The forces at 100 instants, with ``counts`` samples (and half as many more, see `alternating`) and by the march with
    ``fine`` and twice as many steps, extrapolated.
    """
    marched = []
    for n in (fine, 2 * fine):
        t, x, _ = motion(7, size, regular(n))
        marched.append(march(each, stands, x, t[1], compiled)[:: n // 100])
    exact = (4.0 * marched[1] - marched[0]) / 3.0
    ours = []
    for n in counts:
        at, ends = alternating(n)
        t, x, v = motion(7, size, at)
        ours.append(damper(name, each, stands, compiled).force(t, x, voltage=0.0, velocity=v)[ends])
    scale = np.abs(exact).max()
    return [one / scale for one in ours], exact / scale


def of_first_order(ours: list[np.ndarray], exact: np.ndarray, limit: float, order: int = 1) -> None:
    """The errors halve when the samples double, or fall to a quarter where the order is 2, and the limits agree.

    Those of the second order are as uneven as where in a step a kink falls: from the first to the last they do.
    """
    errors, factor = [np.abs(one - exact).max() for one in ours], 2.0**order
    for coarse, fine in pairwise(errors):
        assert (0.8 < factor * fine / coarse < 1.2) if order == 1 else fine < 0.5 * coarse, errors
    if order == 2:
        assert 0.6 < factor ** (len(errors) - 1) * errors[-1] / errors[0] < 1.6, errors
    assert np.abs((factor * ours[-1] - ours[-2]) / (factor - 1.0) - exact).max() < limit, errors


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if EQUATIONS.get(name, EQUATIONS["spring"]).exact else [pytest.mark.prove])
        for name in NAMES
        if not part(name).path_only
    ],
)
def test_a_small_motion_behind_a_compliance_is_of_first_order(name: str) -> None:
    """Where the memory follows the outer end and not the piston, the limit is another one."""
    ours, exact = errors_along(name, reference_of(name, SMALL), COMPLIANCE, SMALL, [200, 400, 800], 600, False)
    of_first_order(
        ours, exact, 3e-3, EQUATIONS[name].order
    )  # it falls with the square of the step, but where memories saturate


MOVING = [name for name, each in EQUATIONS.items() if each.by_path != {}]  # those with a rate


@pytest.mark.prove
@LONG_SIZES
@pytest.mark.parametrize("name", MOVING)
def test_behind_each_element_the_equations_are_approached_at_first_order(name: str, size: float) -> None:
    each = reference_of(name, size)
    counts, fine = ([51_200, 102_400, 204_800], 102_400) if size == FULL else ([12_800, 25_600, 51_200], 25_600)
    if each.order == 2:  # with as many samples the march is no better than what it is compared with
        counts = [n // 8 for n in counts]
    for stands in ("compliance", "free play", "both"):
        ours, exact = errors_along(name, each, elements(size)[stands], size, counts, fine, True)
        of_first_order(ours, exact, 1e-5, each.order)
    t, x, v = motion(7, size, regular(3_200))
    brace, bare = 1.0 / COMPLIANCE.s, damper(name, each, Series(), True)
    behind, same = bare.on_brace(brace), damper(name, each, COMPLIANCE, True)
    np.testing.assert_allclose(
        behind.force(t, x, voltage=0.0, velocity=v), same.force(t, x, voltage=0.0, velocity=v), rtol=1e-9
    )


@pytest.mark.prove
@SIZES
@pytest.mark.parametrize("name", [name for name, each in EQUATIONS.items() if not each.exact])
def test_alone_and_delayed_the_others_are_of_second_order(name: str, size: float) -> None:
    each, tau = reference_of(name, size), elements(size)["delay"].tau
    ours, exact = errors_along(name, each, Series(), size, [400, 3_200, 25_600], 102_400, True)
    errors = [np.abs(one - exact).max() for one in ours]
    assert errors[1] < 2.0 / 8**2 * errors[0], (
        errors
    )  # 8 times as many samples; where a reversal falls between two is by chance
    assert errors[2] < 1e-5, errors
    t, x, v = motion(7, size, regular(102_400))
    now, delayed = (
        damper(name, each, one, True).force(t, x, voltage=0.0, velocity=v) for one in (Series(), Series(tau=tau))
    )
    np.testing.assert_allclose(delayed, late(t, now, tau), rtol=0.0, atol=1e-9 * np.abs(now).max())


@pytest.mark.usefixtures("plain")
@SMALL_FIRST
@pytest.mark.parametrize("name", [name for name in NAMES if not part(name).needs_acceleration])
def test_the_step_of_an_ensemble_and_the_slopes_of_a_response_solve_the_same_equation(name: str, size: float) -> None:
    """From the states on a path: `law`, which the batched kernels use, ends at the force of `advance`, guesses 20 % off;
    both give the slopes of that force."""
    each, rng = reference_of(name, size), np.random.default_rng(1)
    one = damper(name, each, elements(size)["both"])
    composition, t_x_v = one.composition, motion(2, size, uneven(2, 60))
    values, names = one.values(0.0), namespace(one)
    lines = ["def law(s, g0, g1, x0, x1, v0, v1, dt, p):", *series.law(composition.layout)]
    last = composition.n_states - 1
    exec("\n    ".join([*lines, f"return raw, fx, fv, [{', '.join(f'e{k}' for k in range(last))}]"]), names)
    s = np.zeros(composition.n_states)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "the velocity crosses", DampyrWarning)  # lugre: samples are few on purpose
        peak = np.abs(one.force(*t_x_v[:2], voltage=0.0, velocity=t_x_v[2])).max()
    for (t0, x0, v0), (t1, x1, v1) in zip(*(np.transpose(t_x_v)[k : 60 + k] for k in (0, 1)), strict=True):
        piece, before = (x0, x1, v0, v1, t1 - t0), s.copy()
        names["advance_site0"](s, *piece, values)
        guess = s[-1] + 0.2 * peak * rng.uniform(-1.0, 1.0)
        raw, fx, fv, ends = names["law"](before, before[-1], guess, *piece, values)
        np.testing.assert_allclose([raw, *ends], [s[-1], *s[:-1]], rtol=1e-6, atol=1e-6 * max(peak, 1.0))
        np.testing.assert_allclose((fx, fv), names["slopes_site0"](before, *piece, values), rtol=1e-4, atol=1e-6)


def namespace(one: Damper) -> dict[str, object]:
    """The functions of a composition as plain Python, by name."""
    names: dict[str, object] = {
        key: getattr(math, key) for key in ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "copysign", "tan", "atan")
    }
    exec(one.composition.source(), names)
    return names


INNER = [name for name in NAMES if not part(name).needs_acceleration]
RISE = {"sigmoid": {"c": 3000.0}}  # N s/m: it makes force and velocity differ in sign where that turns


@pytest.mark.parametrize("rate", [1e3, 1e4])
@pytest.mark.parametrize("name", INNER)
def test_the_equation_in_series_has_one_root(name: str, rate: float) -> None:
    """What the parts give falls as the guess at their force rises, from any memory, on any short path."""
    each, rng, dt = reference_of(name, FULL).with_numbers(RISE.get(name, {})), np.random.default_rng(2), 1.0 / rate
    one = damper(name, each, elements(FULL)["both"])
    values, names, inner = one.values(0.0), namespace(one), list(part(name).states)
    for _ in range(40):
        s = np.zeros(one.composition.n_states)
        s[: len(inner)] = rng.uniform(-1.0, 1.0, len(inner)) * (1e-3 if part(name).within_stroke else 1.0)
        v0, v1 = 10 ** rng.uniform(-4.0, -1.0) * rng.uniform(-1.0, 1.0, 2)
        x0 = 0.01 * rng.uniform(-1.0, 1.0)
        guesses = np.sort(10 ** rng.uniform(-2.0, 3.0) * rng.standard_normal(20))
        piece = (x0, x0 + 0.5 * dt * (v0 + v1), v0, v1, dt)
        given = np.array([names["phi_site0"](s, 0.0, f, *piece, values) for f in guesses])
        assert np.all(np.diff(guesses - given) > 0.0), (s, piece)


def slow_turns(rate: float, seconds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """t, x and v that turns 2 mm/s beyond zero after strokes of 12 mm/s, and of five times that."""
    t = np.arange(round(seconds * rate)) / rate
    size = np.where(t < 0.2, 1.0, 1.0 + 4.0 * np.sin(np.pi * t / 0.7) ** 2)
    v = size * (0.005 * np.minimum(t / 0.01, 1.0) + 0.007 * np.sin(2 * np.pi * 10.0 * t))
    return t, np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1])) / rate]), v


def rings(force: np.ndarray) -> bool:
    """Whether the force goes up and down in three successive samples, by more than rounding, again and again."""
    jumps = np.diff(force)
    turns = (jumps[1:] * jumps[:-1] < 0.0) & (np.abs(jumps[1:]) > 1e-7 * np.abs(force).max())
    return int(np.sum(turns[1:] & turns[:-1])) > 2


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("rate", [1e3, 1e4])
def test_the_rise_of_a_sigmoid_does_not_ring_behind_a_compliance(rate: float) -> None:
    """A hundredfold of rounding stays one, and no sample answers the one before."""
    one = damper("sigmoid", reference_of("sigmoid", FULL).with_numbers(RISE["sigmoid"]), COMPLIANCE)
    t, x, v = slow_turns(rate, 0.12)
    force = one.force(t, x, voltage=0.0, velocity=v)
    moved = one.force(t, x, voltage=0.0, velocity=v * (1 + 1e-14))
    np.testing.assert_allclose(moved, force, rtol=0.0, atol=1e-10 * np.abs(force).max())
    assert not rings(force)


@pytest.mark.prove  # their kernels take long to compile
@pytest.mark.parametrize("name", INNER)
def test_no_part_in_series_rings_at_any_rate(name: str) -> None:
    """At 1 kHz and 10 kHz, behind a compliance, free play and both: as above, of all parts, for three seconds."""
    each = reference_of(name, FULL).with_numbers(RISE.get(name, {}))
    for rate in (1e3, 1e4):
        t, x, v = slow_turns(rate, 3.0)
        for stands in ("compliance", "free play", "both"):
            one = damper(name, each, elements(FULL)[stands], True)
            force = one.force(t, x, voltage=0.0, velocity=v)
            moved = one.force(t, x, voltage=0.0, velocity=v * (1 + 1e-14))
            np.testing.assert_allclose(moved, force, rtol=0.0, atol=1e-9 * np.abs(force).max())
            assert not rings(force), (rate, stands)


BRACED = [name for name in NAMES if not part(name).needs_acceleration and not part(name).static]
DT = 0.01  # s, of the ground motion
SHAKE = {FULL: 1.5, SMALL: 7e-4}  # m/s2: drifts of up to 10 mm, and of micrometres


def braced_building(names: list[str], size: float):
    """A building with one of the parts on a brace in each storey, for both; and the ground's acceleration (61,)."""
    n = len(names)
    building = shear_building(np.full(n, 150.0), np.linspace(2e5, 1e5, n), damping_ratio=0.03)
    sites, placed = [], {}
    for k, name in enumerate(names):
        each = reference_of(name, size)
        sites.append(Site(each, COMPLIANCE, np.eye(n)[k] - (np.eye(n)[k - 1] if k else 0.0)))
        placed[k + 1] = damper(name, each, Series()).on_brace(1.0 / COMPLIANCE.s)
    t, rng = DT * np.arange(61), np.random.default_rng(5)
    omega, phase = rng.uniform(3.0, 40.0, 6), rng.uniform(0.0, 6.0, 6)
    ground = SHAKE[size] * np.minimum(t / 0.2, 1.0) * np.sin(np.outer(t, omega) + phase).sum(axis=1)
    return building, sites, placed, ground


def agree_in_a_building(
    names: list[str], size: float, steps: list[int], fine: int, samples: int, limit: float, compiled: bool
) -> None:
    building, sites, placed, ground = braced_building(names, size)
    ground = ground[:samples]
    given = (building.M, building.C, building.K, ground, DT)
    marched = [march_building(*given, n, sites, compiled) for n in (fine, 2 * fine)]
    exact = (4.0 * marched[1] - marched[0]) / 3.0
    scale = np.abs(exact).max(axis=0)
    shake = GroundMotion(ground, DT, "random")
    ours = [respond(building, shake, placed, voltage=0.0, step=DT / n).displacement.T / scale for n in steps]
    of_first_order(ours, exact / scale, limit)


#: a part of each kind: without memory, with one of the path, of the velocity, of the stretch, and one that wears
KINDS = ["bingham", "dahl", "hysteretic_biviscous", "generalised_maxwell", "shutting_bleed", "bouc_wen_baber_noori"]


@pytest.mark.prove
@pytest.mark.filterwarnings(
    "ignore:the damper in storey .* fed"
)  # hysteretic_biviscous and sigmoid may, as their pages say
@pytest.mark.parametrize(
    ("names", "size"),
    [
        pytest.param(KINDS, SMALL, id="of each kind"),
        *(  # a kernel of minutes
            pytest.param(BRACED, size, marks=pytest.mark.by_hand, id=f"all-{size * 1e3:g}mm") for size in (FULL, SMALL)
        ),
    ],
)
def test_every_part_on_a_brace_in_a_building(names: list[str], size: float) -> None:
    """One building with each part on a brace of its own in a storey of its own."""
    agree_in_a_building(names, size, [20, 40, 80], 40, 61, 1e-5, True)


@pytest.mark.usefixtures("plain")
@pytest.mark.filterwarnings("ignore:the damper in storey .* fed")
def test_a_memory_of_the_velocity_on_a_brace_in_a_building() -> None:
    agree_in_a_building(["hysteretic_biviscous", "sigmoid"], SMALL, [4, 8], 4, 25, 1e-3, False)


@pytest.mark.usefixtures("plain")
def test_parts_in_series_follow_an_input_that_varies_and_lags() -> None:
    """A voltage that rises and falls, behind a lag: each sample has the numbers of its own input."""
    tau, laws = (
        0.02,
        {"dahl.kx": Polynomial((300.0, 400.0), 0.0, 3.0), "dahl.kw": Polynomial((50.0, 60.0, 20.0), 0.0, 3.0)},
    )
    laws |= {"dahl.rho": Polynomial((3000.0,), 0.0, 3.0), "compliance.s": COMPLIANCE.s, "lag.tau": tau}
    one = Damper("lag + dahl + compliance", laws)
    t, x, v = motion(4, FULL, uneven(4, 80))
    command = 1.5 + 1.5 * np.sin(17.0 * t)
    level, levels = command[0], [command[0]]
    for i in range(1, t.size):  # tau u' = uc - u by steps of a thousandth, at their middles
        h = (t[i] - t[i - 1]) / 1000
        for k in range(1000):
            now = command[i - 1] + (command[i] - command[i - 1]) * (k + 0.5) / 1000
            level += h / (tau + 0.5 * h) * (now - level)
        levels.append(level)
    p = np.column_stack([one.all_laws[f"dahl.{key}"](np.array(levels)) for key in ("kx", "kw", "rho")])
    exact = implicit_rule(EQUATIONS["dahl"], COMPLIANCE, t, x, v, p)
    ours = one.force(t, x, voltage=command, velocity=v)
    np.testing.assert_allclose(ours, exact, rtol=0.0, atol=1e-6 * np.abs(exact).max())


def test_each_page_says_of_which_order_its_step_is() -> None:
    for name in available_parts():
        one = part(name)
        text = (one.module.__doc__ or "").lower()
        if one.states or one.stretch or one.delay or one.lag or one.needs_acceleration:
            assert "exact" in text or "order" in text, (
                f"{name}: say in the docstring of its file of which order its step is"
            )
