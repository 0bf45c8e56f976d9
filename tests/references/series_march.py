"""The documented equations of every part, and of what stands in series with it, solved by means that share no code with dampyr.

`EQUATIONS` has, for every part that makes a force, the equations of docs/reference/models.md: the force from the piston's
velocity u, its place y and the memory w, and how w follows a piece of path. Two solvers use them:

`implicit_rule`
    what models.md says of a sampled path: at each sample the force is the root of F = G(u, y, w) with y = x - z(F) and u = v
    less the backward difference of z; scipy's bracketing method finds it.
`march`
    the equations themselves: implicit steps of the piston's place (BDF2), each solved for u by Ridders' method in a bracket. In
    a building the floors follow by Newmark's average acceleration. All is of second order in the step.

The functions run as plain Python and, for long marches, compiled by numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numba
import numpy as np
from numba.extending import register_jitable
from scipy.optimize import brentq

from dampyr.models.part import part

WHAT_TO_ADD = (
    "{0} has no reference: write its documented equations into EQUATIONS of tests/references/series_march.py, "
    "as force(u, y, w, p) and follow(w, y0, y1, u0, u1, h, p)"
)
SWEEPS = 3  # each leaves less than a thousandth of what is missing, as a step moves a floor little
NO_MEMORY = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Equation:
    """One part: its numbers, its force and its memory of up to four numbers.

    ``exact``: the step of its memory is exact between samples. ``by_path``: numbers with which its force depends on the path
    alone, so that it is exact at any step in series too; None where there are none. ``small``: numbers for motions of
    micrometres, where those of ``values`` would leave the part at rest. ``order``: that of the error behind a stretch; the
    backward difference makes it 1 where the force depends on the velocity at the end of a step.
    """

    values: dict[str, float]
    force: Callable[..., float]
    follow: Callable[..., Any] = None  # type: ignore[assignment]
    exact: bool = True
    by_path: dict[str, float] | None = None
    small: dict[str, float] = field(default_factory=dict)
    order: int = 1

    def __post_init__(self) -> None:
        if self.follow is None:
            object.__setattr__(self, "follow", forgets)

    def with_numbers(self, numbers: dict[str, float]) -> Equation:
        """The same part with other numbers; those of its names that are given."""
        return replace(self, values=self.values | numbers)

    @property
    def p(self) -> tuple[float, ...]:
        return tuple(map(float, self.values.values()))

    @cached_property
    def compiled(self) -> tuple[Any, Any]:
        return numba.njit(self.force), numba.njit(self.follow)


def equation(name: str) -> Equation | None:
    """The reference of a part, None for one that is no force; the test fails for a part that has no reference."""
    if name in EQUATIONS:
        missing = set(part(name).parameters) ^ set(EQUATIONS[name].values)
        assert not missing, (
            f"{name}: the numbers of its reference in series_march.py and its parameters differ: {missing}"
        )
        return EQUATIONS[name]
    assert name in NO_FORCE, WHAT_TO_ADD.format(name)
    return None


#: Parts without a force: what stretches (see `stretch`), what delays, lags or multiplies.
NO_FORCE = ("compliance", "free_play", "delay", "lag", "direction_factor")


@register_jitable
def stretch(f, s, g, fc):
    """z(F) of a compliance s and of free play g with its closing force fc."""
    return s * f + g * f / math.sqrt(f * f + fc * fc)


@register_jitable
def forgets(w, y0, y1, u0, u1, h, p):
    return w


@register_jitable
def held(w):
    return min(max(w, -1.0), 1.0)


@register_jitable
def follows_velocity(w, y0, y1, u0, u1, h, p):
    """w' = u'/vh, held between -1 and 1; vh is the last parameter of both parts that have it."""
    return (held(w[0] + (u1 - u0) / p[3]), 0.0, 0.0, 0.0)


@register_jitable
def bilinear(u, y, w, p):
    Q, _, k2 = p
    return k2 * y + Q * w[0]


@register_jitable
def follows_bilinear(w, y0, y1, u0, u1, h, p):
    return (held(w[0] + (y1 - y0) / p[1]), 0.0, 0.0, 0.0)


@register_jitable
def bingham(u, y, w, p):
    c0, fc, v0 = p
    return c0 * u + fc * math.copysign(1.0, u) * -math.expm1(-abs(u) / v0)


@register_jitable
def biviscous(u, y, w, p):
    c, fy, vy = p
    return c * u + fy * held(u / vy)


@register_jitable
def bouc_wen(u, y, w, p):
    return p[0] * u + p[1] * y + p[2] * w[0]


@register_jitable
def follows_bouc_wen(w, y0, y1, u0, u1, h, p):
    """The equation of n = 2 in closed form: y' = 1 - y^2 for y >= 0 and 1 + c y^2 below, over xi = rho |dy|, y = s w."""
    s, xi, root = math.copysign(1.0, y1 - y0), p[3] * abs(y1 - y0), math.sqrt(2.0 * p[4] - 1.0)
    y = s * w[0]
    if y < 0.0:
        to_zero = -math.atan(root * y) / root
        if xi <= to_zero:
            return (s * math.tan(math.atan(root * y) + root * xi) / root, 0.0, 0.0, 0.0)
        xi, y = xi - to_zero, 0.0
    t = math.tanh(xi)
    return (s * (y + t) / (1.0 + y * t), 0.0, 0.0, 0.0)


@register_jitable
def bouc_wen_baber_noori(u, y, w, p):
    return p[0] * y + p[1] * w[0]


@register_jitable
def pinched_rate(s, w, e, p):
    """dw/dy of the equations of the page, s the direction."""
    _, _, rho, sigma, n, zetas, q, rate, Shi, deltaShi, lamda, deltanu, deltaeta = p
    nu, taken = 1.0 + deltanu * e, zetas * -math.expm1(-rate * e)
    apart = (s * w - q * nu ** (-1.0 / n)) / ((Shi + deltaShi * e) * (lamda + taken))
    h = 1.0 - taken * math.exp(-apart * apart)
    return rho * h / (1.0 + deltaeta * e) * (1.0 - nu * abs(w) ** n * (1.0 if s * w > 0.0 else 1.0 - 2.0 * sigma))


@register_jitable
def follows_pinched(w, y0, y1, u0, u1, h, p):
    """One step of Runge and Kutta's fourth order along the path."""
    d, s, b, e = y1 - y0, math.copysign(1.0, y1 - y0), w[0], w[1]
    a1 = pinched_rate(s, b, e, p)
    a2 = pinched_rate(s, b + 0.5 * d * a1, e + 0.5 * d * b, p)
    a3 = pinched_rate(s, b + 0.5 * d * a2, e + 0.5 * d * (b + 0.5 * d * a1), p)
    a4 = pinched_rate(s, b + d * a3, e + d * (b + 0.5 * d * a2), p)
    end = b + d * (a1 + 2 * a2 + 2 * a3 + a4) / 6
    return (end, e + d * (b + 4 * (b + d * (5 * a1 + 2 * a2 + 2 * a3 - a4) / 16) + end) / 6, 0.0, 0.0)


@register_jitable
def choi_polynomial(u, y, w, p):
    f = 0.0
    for i in range(7):
        f += p[i] * (10.0 * u) ** i * (1.0 if i % 2 else w[0])
    return f


@register_jitable
def follows_choi(w, y0, y1, u0, u1, h, p):
    return (held(w[0] + (u1 - u0) / p[7]), 0.0, 0.0, 0.0)


@register_jitable
def dahl(u, y, w, p):
    return p[0] * u + p[1] * w[0]


@register_jitable
def follows_dahl(w, y0, y1, u0, u1, h, p):
    s = math.copysign(1.0, y1 - y0)
    return (w[0] - (w[0] - s) * -math.expm1(-p[2] * abs(y1 - y0)), 0.0, 0.0, 0.0)


@register_jitable
def asymmetric(u, y, w, p):
    ce, cc, fe, fc, v0 = p
    c, f = (ce, fe) if u > 0.0 else (cc, fc)
    return c * u + f * math.tanh(u / v0)


@register_jitable
def song_rate(s, y, w, p):
    """dw/dx of the source's equation, s the direction."""
    _, _, _, rho, n, b2, b3, b4, b5, b6 = p
    x, z = math.copysign(1.0, y), math.copysign(1.0, w)
    return rho * (1.0 - abs(w) ** n * (s * z + b2 * x * s + b3 * x * z + b4 * s + b5 * z + b6 * x))


@register_jitable
def follows_song(w, y0, y1, u0, u1, h, p):
    """Runge and Kutta's fourth order along each piece between the signs' changes, which are found by a secant of z."""
    s, at, b, d = math.copysign(1.0, y1 - y0), y0, w[0], y1 - y0
    for _ in range(4):
        d = y1 - at
        if at * y1 < 0.0 and abs(at) > 1e-15:
            d = -at
        mid = at + 0.5 * d
        sign = math.copysign(1.0, b) if b != 0.0 else s
        if b * s < 0.0:
            slope = song_rate(s, mid, b, p)
            d = s * min(abs(d), max(abs(b / slope), 1e-15)) if slope > 0.0 else d
        a1 = song_rate(s, mid, b if b != 0.0 else 1e-300 * sign, p)
        a2 = song_rate(s, mid, math.copysign(b + 0.5 * d * a1, sign), p)
        a3 = song_rate(s, mid, math.copysign(b + 0.5 * d * a2, sign), p)
        a4 = song_rate(s, mid, math.copysign(b + d * a3, sign), p)
        b, at = b + d * (a1 + 2 * a2 + 2 * a3 + a4) / 6, at + d
        if at == y1:
            break
    return (b, 0.0, 0.0, 0.0)


@register_jitable
def triple_pendulum(u, y, w, p):
    return p[0] * (y - w[0] - w[1] - w[2]) / p[9]


@register_jitable
def slid(u, f, r, ell, d):
    return min(max(u + ell * max(f - u / ell - r, 0.0) - ell * max(u / ell - f - r, 0.0), -d), d)


@register_jitable
def follows_pendulum(w, y0, y1, u0, u1, h, p):
    """The force over f1 by halving a bracket."""
    _, r2, r3, l1, l2, l3, d1, d2, d3, uy = p
    reach = d1 + d2 + d3 + abs(w[0]) + abs(w[1]) + abs(w[2])
    low, high = (y1 - reach) / uy, (y1 + reach) / uy
    for _ in range(90):
        f = 0.5 * (low + high)
        if uy * f + slid(w[0], f, 1.0, l1, d1) + slid(w[1], f, r2, l2, d2) + slid(w[2], f, r3, l3, d3) > y1:
            high = f
        else:
            low = f
    return (slid(w[0], f, 1.0, l1, d1), slid(w[1], f, r2, l2, d2), slid(w[2], f, r3, l3, d3), 0.0)


@register_jitable
def power_law(u, y, w, p):
    C, alpha = p
    return C * u * (u * u + 1e-10) ** (0.5 * (alpha - 1.0))


@register_jitable
def place_friction(u, y, w, p):
    g, y0, ell, vf = p
    return g * (100.0 * (ell * w[0] - y0)) ** 2 * math.tanh(u / vf)


@register_jitable
def follows_place(w, y0, y1, u0, u1, h, p):
    s = math.copysign(1.0, y1 - y0)
    return (w[0] - (w[0] - s) * -math.expm1(-abs(y1 - y0) / p[2]), 0.0, 0.0, 0.0)


@register_jitable
def shutting_bleed(u, y, w, p):
    c, fy, vy, b, _ = p
    if u == 0.0:
        return 0.0
    s, h, passing = math.copysign(1.0, u), fy * math.tanh(abs(u) / vy) + c * abs(u), b * abs(u)
    shut = ((1.0 + s * w[0]) / 2.0) ** 4
    return s * ((1.0 - shut) * passing * h / math.hypot(passing, h) + shut * h)


@register_jitable
def follows_bleed(w, y0, y1, u0, u1, h, p):
    return (held(w[0] + (y1 - y0) / p[4]), 0.0, 0.0, 0.0)


@register_jitable
def force_table(u, y, w, p):
    rises, f, reached = p[6:12] if u > 0.0 else p[12:18], 0.0, 0.0
    for i in range(6):
        if abs(u) > reached:
            f += rises[i] * (abs(u) - reached if i == 5 else min(abs(u) - reached, p[i])) / p[i]
        reached += p[i]
    return math.copysign(f, u)


@register_jitable
def gamota_filisko(u, y, w, p):
    fc, d, _, _, _ = p
    return fc * (w[0] - w[1]) / d


@register_jitable
def gamota_filisko_rate(u, q, e, p):
    """With k2 = 1 for the unit of force: c0 = d/vc, k1 = r, c1 = tau, fc = d."""
    _, d, vc, r, tau = p
    f = q - e
    return u - (f - held(f / d) * d) * vc / d, (f - r * e) / tau


@register_jitable
def follows_gamota_filisko(w, y0, y1, u0, u1, h, p):
    """One step of Runge and Kutta's fourth order at the mean velocity."""
    u, b, e = (y1 - y0) / h, w[0], w[1]
    a1, b1 = gamota_filisko_rate(u, b, e, p)
    a2, b2 = gamota_filisko_rate(u, b + 0.5 * h * a1, e + 0.5 * h * b1, p)
    a3, b3 = gamota_filisko_rate(u, b + 0.5 * h * a2, e + 0.5 * h * b2, p)
    a4, b4 = gamota_filisko_rate(u, b + h * a3, e + h * b3, p)
    return (b + h * (a1 + 2 * a2 + 2 * a3 + a4) / 6, e + h * (b1 + 2 * b2 + 2 * b3 + b4) / 6, 0.0, 0.0)


@register_jitable
def generalised_maxwell(u, y, w, p):
    return p[0] * y + p[1] * w[0] + p[2] * w[1] + p[3] * w[2]


@register_jitable
def relaxes(e, step, h, tau):
    """e' = step/h - e/tau over h: towards the stretch at which the dashpot takes the whole rate."""
    steady = step / h * tau
    return steady + (e - steady) * math.exp(-h / tau)


@register_jitable
def follows_maxwell(w, y0, y1, u0, u1, h, p):
    d, tau = y1 - y0, p[4]
    return (relaxes(w[0], d, h, tau), relaxes(w[1], d, h, 10.0 * tau), relaxes(w[2], d, h, 100.0 * tau), 0.0)


@register_jitable
def gas_spring(u, y, w, p):
    f0, L, gamma = p
    return f0 * (1.0 - (1.0 + y / L) ** -gamma)


@register_jitable
def follows_hardening(w, y0, y1, u0, u1, h, p):
    """The equation of n = 2 in closed form: y' = 1 + h y^2 for y >= 0 and 1 + (2 + h) y^2 below, over xi = rho |dy|."""
    s, xi, y = math.copysign(1.0, y1 - y0), p[3] * abs(y1 - y0), w[0] * math.copysign(1.0, y1 - y0)
    if y < 0.0:
        root = math.sqrt(2.0 + p[4])
        if xi <= -math.atan(root * y) / root:
            return (s * math.tan(math.atan(root * y) + root * xi) / root, 0.0, 0.0, 0.0)
        xi, y = xi + math.atan(root * y) / root, 0.0
    root = math.sqrt(p[4])
    return (s * math.tan(math.atan(root * y) + root * xi) / root, 0.0, 0.0, 0.0)


@register_jitable
def hyperbolic_tangent(u, y, w, p):
    c, ft, v0, s = p
    return c * u + ft * math.tanh((u + s * y) / v0)


@register_jitable
def hysteretic_biviscous(u, y, w, p):
    c, fy, vy, vh = p
    return c * u + fy * held((u - vh * w[0]) / vy)


@register_jitable
def sigmoid(u, y, w, p):
    ft, c, vk, vh = p
    return (ft + c * abs(u)) * math.tanh((u - vh * w[0]) / vk)


@register_jitable
def maxwell_slip(u, y, w, p):
    return p[0] * u + p[1] * (w[0] / 16 + 3 * w[1] / 16 + 5 * w[2] / 16 + 7 * w[3] / 16)


@register_jitable
def follows_maxwell_slip(w, y0, y1, u0, u1, h, p):
    step = 4.0 * p[2] * (y1 - y0)
    return (held(w[0] + step), held(w[1] + step / 3), held(w[2] + step / 5), held(w[3] + step / 7))


@register_jitable
def stribeck(u, e, vs):
    return (1.0 + e * math.exp(-((u / vs) ** 2))) / (1.0 + e)


@register_jitable
def lugre(u, y, w, p):
    fc, sigma1, sigma2, _, e, vs = p
    static = (1.0 + e) * fc
    return static * w[0] + sigma1 * (u - abs(u) * w[0] / stribeck(u, e, vs)) + sigma2 * u


@register_jitable
def follows_lugre(w, y0, y1, u0, u1, h, p):
    """w' = rho/(1+e) (u - |u| w/h(u)) at the mean velocity of the step, where it is linear in w."""
    u = (y1 - y0) / h
    e, target = p[4], math.copysign(stribeck(u, p[4], p[5]), u)
    return (target + (w[0] - target) * math.exp(-p[3] / (1.0 + e) * abs(u) / abs(target) * h), 0.0, 0.0, 0.0)


@register_jitable
def modified_bouc_wen(u, y, w, p):
    kw, k1, vc, r, kappa = p[:5]
    c1 = kw / vc
    node = (kw * w[0] + kappa * kw * w[1] + r * c1 * u) / (c1 + r * c1)  # c1 y' = kw w + k0 e + c0 (u - y')
    return c1 * node + k1 * y


@register_jitable
def modified_bouc_wen_rate(u, w, e, p):
    _, _, vc, r, kappa, rho, sigma, n = p
    slide = u - vc * (w + kappa * e + r * u / vc) / (1.0 + r)
    turned = rho * (slide - sigma * abs(slide) * abs(w) ** (n - 1.0) * w + (sigma - 1.0) * slide * abs(w) ** n)
    return turned, slide


@register_jitable
def follows_modified_bouc_wen(w, y0, y1, u0, u1, h, p):
    """One step of Runge and Kutta's fourth order at the mean velocity."""
    u, b, e = (y1 - y0) / h, w[0], w[1]
    a1, b1 = modified_bouc_wen_rate(u, b, e, p)
    a2, b2 = modified_bouc_wen_rate(u, b + 0.5 * h * a1, e + 0.5 * h * b1, p)
    a3, b3 = modified_bouc_wen_rate(u, b + 0.5 * h * a2, e + 0.5 * h * b2, p)
    a4, b4 = modified_bouc_wen_rate(u, b + h * a3, e + h * b3, p)
    return (b + h * (a1 + 2 * a2 + 2 * a3 + a4) / 6, e + h * (b1 + 2 * b2 + 2 * b3 + b4) / 6, 0.0, 0.0)


@register_jitable
def spring(u, y, w, p):
    return p[0] * y


@register_jitable
def offset(u, y, w, p):
    return p[0]


@register_jitable
def nothing(u, y, w, p):
    return 0.0


#: c of the sigmoid is 0: with more, its force in series is no single answer, as its page says. Inertia is at the outer end.
EQUATIONS = {
    "asymmetric": Equation({"ce": 2000, "cc": 800, "fe": 120, "fc": 60, "v0": 0.01}, asymmetric),
    "asymmetric_bouc_wen": Equation(
        {"c0": 700, "k0": 900, "kw": 150, "rho": 400, "n": 1.6}
        | {"b2": -0.25, "b3": 0.06, "b4": 0.24, "b5": -0.26, "b6": -0.24},
        bouc_wen,
        follows_song,
        exact=False,
        small={"rho": 3e5, "kw": 5},
    ),
    "bilinear": Equation(
        {"Q": 150, "uy": 8e-4, "k2": 9000}, bilinear, follows_bilinear, by_path={}, small={"uy": 2e-6}
    ),
    "bingham": Equation({"c0": 800, "fc": 300, "v0": 0.01}, bingham),
    "biviscous": Equation({"c": 3000, "fy": 400, "vy": 0.012}, biviscous),
    "bouc_wen": Equation(
        {"c0": 700, "k0": 900, "kw": 150, "rho": 2500, "sigma": 0.8, "n": 2},
        bouc_wen,
        follows_bouc_wen,
        by_path={"c0": 0},
    ),
    "bouc_wen_baber_noori": Equation(
        {"k0": 5e3, "kw": 150, "rho": 1500, "sigma": 0.7, "n": 1.6, "zetas": 0.9, "q": 0.1, "p": 60}
        | {"Shi": 0.4, "deltaShi": 2, "lamda": 0.3, "deltanu": 4, "deltaeta": 6},
        bouc_wen_baber_noori,
        follows_pinched,
        exact=False,
        small={"rho": 3e5, "kw": 5, "p": 6e4, "deltaShi": 2e3, "deltanu": 4e3, "deltaeta": 6e3},
        order=2,
    ),
    "choi_polynomial": Equation(
        {"p0": 20, "p1": 300, "p2": 5, "p3": 3, "p4": 0.1, "p5": 0.05, "p6": 0.001, "vh": 0.02},
        choi_polynomial,
        follows_choi,
        small={"vh": 2e-4, "p0": 0.5},
    ),
    "dahl": Equation({"kx": 800, "kw": 150, "rho": 3000}, dahl, follows_dahl, by_path={"kx": 0}),
    "force_table": Equation(
        {"w1": 0.02, "w2": 0.03, "w3": 0.05, "w4": 0.1, "w5": 0.1, "w6": 0.2}
        | {"e1": 90, "e2": 60, "e3": 40, "e4": 60, "e5": 50, "e6": 150}
        | {"c1": 40, "c2": 50, "c3": 30, "c4": 20, "c5": 40, "c6": 20},
        force_table,
    ),
    "gamota_filisko": Equation(
        {"fc": 150, "d": 1e-3, "vc": 0.1, "r": 0.5, "tau": 0.02},
        gamota_filisko,
        follows_gamota_filisko,
        exact=False,
        small={"d": 1e-6, "vc": 1e-3, "tau": 0.01},
        order=2,
    ),
    "gas_spring": Equation({"f0": 200, "L": 0.04, "gamma": 1.3}, gas_spring, by_path={}),
    "generalised_maxwell": Equation(
        {"k0": 2e4, "k1": 1.5e4, "k2": 8e3, "k3": 1.2e4, "tau": 0.002}, generalised_maxwell, follows_maxwell, order=2
    ),
    "hardening_bouc_wen": Equation(
        {"c0": 700, "k0": 900, "kw": 150, "rho": 60, "h": 0.5, "n": 2},
        bouc_wen,
        follows_hardening,
        by_path={"c0": 0},
        small={"rho": 1.2e5, "kw": 5},
    ),
    "hyperbolic_tangent": Equation({"c": 800, "ft": 250, "v0": 0.01, "s": 0.4}, hyperbolic_tangent),
    "hysteretic_biviscous": Equation(
        {"c": 3000, "fy": 560, "vy": 0.012, "vh": 0.008}, hysteretic_biviscous, follows_velocity, small={"vh": 2e-4}
    ),
    "inertia": Equation({"m": 3}, nothing, by_path={}),
    "lugre": Equation(
        {"fc": 120, "sigma1": 300, "sigma2": 900, "rho": 3000, "e": 0.3, "vs": 0.02}, lugre, follows_lugre, exact=False
    ),
    "maxwell_slip": Equation(
        {"kx": 800, "kw": 150, "rho": 3000}, maxwell_slip, follows_maxwell_slip, by_path={"kx": 0}
    ),
    "modified_bouc_wen": Equation(
        {"kw": 300, "k1": 500, "vc": 0.02, "r": 0.3, "kappa": 10, "rho": 2500, "sigma": 0.8, "n": 2},
        modified_bouc_wen,
        follows_modified_bouc_wen,
        exact=False,
    ),
    "offset": Equation({"f0": 40}, offset, by_path={}),
    "place_friction": Equation({"g": 20, "y0": 0.005, "ell": 0.02, "vf": 0.02}, place_friction, follows_place),
    "power_law": Equation({"C": 900, "alpha": 0.4}, power_law),
    "shutting_bleed": Equation(
        {"c": 1700, "fy": 185, "vy": 0.005, "b": 4.6e4, "d": 2e-4}, shutting_bleed, follows_bleed, small={"d": 2e-6}
    ),
    "sigmoid": Equation({"ft": 560, "c": 0, "vk": 0.03, "vh": 0.008}, sigmoid, follows_velocity, small={"vh": 2e-4}),
    "spring": Equation({"k0": 4e4}, spring, by_path={}),
    "triple_pendulum": Equation(
        {
            "f1": 150,
            "r2": 2,
            "r3": 3,
            "l1": 2e-3,
            "l2": 4e-3,
            "l3": 5e-3,
            "d1": 2e-3,
            "d2": 4e-3,
            "d3": 0.01,
            "uy": 1e-4,
        },
        triple_pendulum,
        follows_pendulum,
        by_path={},
        small={"f1": 2, "l1": 1e-6, "l2": 2e-6, "l3": 2.5e-6, "d1": 1e-6, "d2": 2e-6, "d3": 5e-6, "uy": 1e-7},
    ),
}


@dataclass(frozen=True)
class Series:
    """What stands in series, m/N, m and N; and the delay of the whole, s."""

    s: float = 0.0
    g: float = 0.0
    fc: float = 30.0
    tau: float = 0.0

    @property
    def stretch(self) -> tuple[float, float, float]:
        return self.s, self.g, self.fc


def implicit_rule(each: Equation, series: Series, t, x, v, p=None) -> np.ndarray:
    """The force (n,) at the samples by the rule that models.md states, from no force and no memory; not delayed.

    ``p`` (n, P) where the numbers change along the path.
    """
    forces, w, rate, before = np.zeros(t.size), NO_MEMORY, None, 0.0
    for i in range(1, t.size):
        now = each.p if p is None else tuple(p[i])
        step = Step(each, series, now, w, rate, before, (x[i - 1], x[i]), (v[i - 1], v[i]), t[i] - t[i - 1])
        before = forces[i] = step.root()
        rate, w = step.rate(before), step.end(before)[2]
    return forces


@dataclass
class Step:
    """One step of `implicit_rule`; ``rate`` is that of the stretch at the end of the step before, None at the first."""

    each: Equation
    series: Series
    p: tuple[float, ...]
    w: tuple[float, ...]
    before: float | None
    force0: float
    x: tuple[float, float]
    v: tuple[float, float]
    h: float

    def rate(self, f: float) -> float:
        return (stretch(f, *self.series.stretch) - stretch(self.force0, *self.series.stretch)) / self.h

    def end(self, f: float) -> tuple[float, float, Any]:
        """The piston's velocity and place at the end, and the memory."""
        z0, z1, rate = stretch(self.force0, *self.series.stretch), stretch(f, *self.series.stretch), self.rate(f)
        u0, u1 = self.v[0] - (rate if self.before is None else self.before), self.v[1] - rate
        y0, y1 = self.x[0] - z0, self.x[1] - z1
        return u1, y1, self.each.follow(self.w, y0, y1, u0, u1, self.h, self.p)

    def excess(self, f: float) -> float:
        u, y, w = self.end(f)
        return f - self.each.force(u, y, w, self.p)

    def root(self) -> float:
        """The force at the end; what the parts give falls with the guess, or rises less than it: the root lies between the two
        then, or a little beyond."""
        excess = self.excess(self.force0)
        low, high = sorted((self.force0, self.force0 - excess))
        if excess == 0.0 or low == high:
            return low
        wide = 1e-9 * (high - low) + 1e-12 * (1.0 + abs(low) + abs(high))  # an end may be the root, but for rounding
        low, high = low - wide, high + wide
        while self.excess(low) > 0.0:
            low -= high - low
        while self.excess(high) < 0.0:
            high += high - low
        return float(brentq(self.excess, low, high, xtol=1e-14, rtol=1e-15))


@register_jitable
def too_far(force, follow, w, ym, y0, u0, u, h, target, s, g, fc, p):
    """y + z(F) less ``target`` if the piston ends the step with the velocity u."""
    y = (4.0 * y0 - ym + 2.0 * h * u) / 3.0
    f = force(u, y, follow(w, y0, y, u0, u, h, p), p)
    return y + stretch(f, s, g, fc) - target


@register_jitable
def solve_step(force, follow, w, ym, y0, u0, h, target, s, g, fc, p):
    """The piston's velocity at the end of a step, its place, the force and the memory: Ridders' method in a bracket."""
    low = high = u0
    at = too_far(force, follow, w, ym, y0, u0, u0, h, target, s, g, fc, p)
    below = above = at
    reach = 1e-3 * 1.5 * abs(at) / h + 1e-15
    while at != 0.0 and below > 0.0:
        high, above = low, below
        low -= reach
        reach *= 4.0
        below = too_far(force, follow, w, ym, y0, u0, low, h, target, s, g, fc, p)
    while at != 0.0 and above < 0.0:
        low, below = high, above
        high += reach
        reach *= 4.0
        above = too_far(force, follow, w, ym, y0, u0, high, h, target, s, g, fc, p)
    for _ in range(60):
        if high - low <= 1e-12 * (abs(low) + abs(high)) + 1e-16 or below == 0.0 or above == 0.0:
            break
        mid = 0.5 * (low + high)
        centre = too_far(force, follow, w, ym, y0, u0, mid, h, target, s, g, fc, p)
        if centre == 0.0:
            low = high = mid
            break
        new = mid - (mid - low) * centre / math.sqrt(centre * centre - below * above)
        there = too_far(force, follow, w, ym, y0, u0, new, h, target, s, g, fc, p)
        if centre < 0.0:
            low, below = mid, centre
        else:
            high, above = mid, centre
        if there < 0.0 and new > low:
            low, below = new, there
        elif there >= 0.0 and new < high:
            high, above = new, there
    u = low if abs(below) < abs(above) else high
    y = (4.0 * y0 - ym + 2.0 * h * u) / 3.0
    w = follow(w, y0, y, u0, u, h, p)
    return u, y, force(u, y, w, p), w


@register_jitable
def _march(force, follow, x, h, s, g, fc, p, out):
    ym, y0, u, w = x[0], x[0], 0.0, (0.0, 0.0, 0.0, 0.0)
    for i in range(1, x.size):
        u, y, f, w = solve_step(force, follow, w, ym, y0, u, h, x[i], s, g, fc, p)
        ym, y0, out[i] = y0, y, f
    return out


_compiled_march = numba.njit(_march)
compiled_step = numba.njit(solve_step)


def march(each: Equation, series: Series, x, h: float, compiled: bool) -> np.ndarray:
    """The force (n,) along samples of x that are ``h`` s apart, from rest; not delayed."""
    force, follow = each.compiled if compiled else (each.force, each.follow)
    return (_compiled_march if compiled else _march)(force, follow, x, h, *series.stretch, each.p, np.zeros(x.size))


@dataclass(frozen=True)
class Site:
    """A part in series between two floors of a building; ``row`` (n,) makes its stroke of the floors' displacements."""

    each: Equation
    series: Series
    row: np.ndarray


def march_building(M, C, K, ground, dt: float, steps: int, sites: list[Site], compiled: bool) -> np.ndarray:
    """The floors' displacements (samples, n) from rest at the samples of the ground's acceleration, ``dt`` s apart and linear
    between them, in ``steps`` steps a sample.

    The stroke at the end of a step is linear in the forces there; they are solved for one by one, in sweeps, until they stand.
    """
    h, n, rows = dt / steps, len(M), np.array([site.row for site in sites])
    inverse = np.linalg.inv(M + 0.5 * h * C + 0.25 * h * h * K)
    gives = 0.25 * h * h * rows @ inverse @ rows.T
    functions = [site.each.compiled if compiled else (site.each.force, site.each.follow) for site in sites]
    solve = compiled_step if compiled else solve_step
    q, v, a, F = np.zeros(n), np.zeros(n), -np.full(n, ground[0]), np.zeros(len(sites))
    pistons = [
        (0.0, 0.0, 0.0, NO_MEMORY) for _ in sites
    ]  # the place before the last, the last one, the velocity, the memory
    ends, out = list(pistons), [q]
    for i in range((len(ground) - 1) * steps):
        k, j = divmod(i + 1, steps)
        now = ground[k] + (ground[k + 1] - ground[k]) * j / steps if j else ground[k]
        free_a = inverse @ (-M.sum(axis=1) * now - C @ (v + 0.5 * h * a) - K @ (q + h * v + 0.25 * h * h * a))
        free_x = rows @ (q + h * v + 0.25 * h * h * (a + free_a))
        for _ in range(SWEEPS):
            for d, (site, (force, follow), (ym, y0, u0, w)) in enumerate(zip(sites, functions, pistons, strict=True)):
                s, g, fc = site.series.stretch
                target = free_x[d] - gives[d] @ F + gives[d, d] * F[d]
                u, y, F[d], turned = solve(force, follow, w, ym, y0, u0, h, target, s + gives[d, d], g, fc, site.each.p)
                ends[d] = (y0, y, u, turned)
        pistons = list(ends)
        a1 = free_a - inverse @ (rows.T @ F)
        q, v, a = q + h * v + 0.25 * h * h * (a + a1), v + 0.5 * h * (a + a1), a1
        if j == 0:
            out.append(q)
    return np.array(out)
