"""Causes planted at random in dampers of three kinds: what a fit that misses proposes first is right nearly always."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from tests.endurance import Endurance

import dampyr as dp
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.model_choice.missing_effect import list_missing_effects
from dampyr.models import Damper
from dampyr.records import Record

Array = np.ndarray
Force = Callable[[Array, Array, Array], Array]
CURIOUS = dp.identification.FitThresholds(unexplained=1.0)  # the trials are called by the test


@dataclass
class Plant:
    """Two to five sines of a damper, with something planted; ``model`` is what is fitted, ``fault`` what must be named."""

    rng: np.random.Generator
    options: dict[str, Any] = field(default_factory=dict)
    records: list[Record] = field(default_factory=list)
    fault: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        rng = self.rng
        self.motions = [
            (10 ** rng.uniform(-2.7, -1.7), 10 ** rng.uniform(-0.5, 0.6)) for _ in range(rng.integers(2, 6))
        ]
        self.noise, self.with_velocity = rng.choice([0.002, 0.01, 0.03]), rng.random() < 0.5
        self.friction, self.damping = 10 ** rng.uniform(1.7, 3.0), 10 ** rng.uniform(2.3, 3.5)
        dahl = {"dahl.kx": self.damping, "dahl.kw": self.friction, "dahl.rho": 10 ** rng.uniform(3.0, 4.0)}
        smooth = {"c": self.damping, "ft": self.friction, "v0": 0.005, "s": 0.0}
        self.model, self.numbers = [
            ("dahl", dahl),
            ("dahl + spring", dahl | {"spring.k0": 5.0 * self.friction}),
            ("hyperbolic_tangent", {f"hyperbolic_tangent.{key}": value for key, value in smooth.items()}),
        ][rng.integers(3)]

    def damper(self, part: str = "", **further: float) -> Force:
        """The force of the damper, with one part more."""
        names = [*self.model.split(" + "), *([part] if part else [])]
        made = Damper(tuple(names), self.numbers | {f"{part}.{key}": value for key, value in further.items()})
        return lambda t, x, v: made.force(t, x, voltage=0.0)

    def record(self, force: Force, cycles: float = 6.0, voltage: float = 0.0, motions: int | None = None) -> None:
        """Sines of a force with noise and an offset."""
        for stroke, frequency in self.motions[:motions]:
            t = np.arange(0.0, cycles / frequency, 1.0 / (150.0 * frequency))
            x = stroke * np.sin(2.0 * np.pi * frequency * t) * np.clip(t * frequency, 0.0, 1.0)
            v = np.gradient(x, t)
            exact = force(t, x, v)
            spread = float(np.std(exact))
            off = self.rng.normal(0.0, self.noise * spread, t.size) + self.rng.normal(0.0, 0.02 * spread)
            velocity = v if self.with_velocity else None
            name = f"r{len(self.records)}"
            self.records.append(Record(t, x, exact + off, voltage=voltage, velocity=velocity, name=name))


def backlash(plant: Plant) -> None:
    gap = min(stroke for stroke, _ in plant.motions) * plant.rng.uniform(0.15, 0.6)
    plant.record(plant.damper("free_play", g=gap, fc=0.02 * plant.friction))
    plant.fault = ("a free play",)


def asymmetry(plant: Plant) -> None:
    force, weaker, first = plant.damper(), plant.rng.uniform(0.1, 0.5), plant.rng.random() < 0.5
    plant.record(lambda t, x, v: force(t, x, v) * np.where((v > 0.0) == first, 1.0, weaker))
    plant.fault = ("differs between extension and compression",)


def heat(plant: Plant) -> None:
    force, share = plant.damper(), plant.rng.uniform(0.15, 0.6)

    def hot(t: Array, x: Array, v: Array) -> Array:
        cold = force(t, x, v)
        energy = np.cumsum(cold * np.gradient(x))
        return cold * (0.25 + 0.75 * np.exp(-energy / (energy[-1] * share)))

    plant.record(hot, cycles=15.0)
    plant.fault = ("heats up",)


def delay(plant: Plant) -> None:
    force, late = plant.damper(), plant.rng.uniform(0.04, 0.1)
    plant.record(lambda t, x, v: np.interp(t - late, t, force(t, x, v)))
    plant.fault = ("a delay",)


def clipped(plant: Plant) -> None:
    plant.record(plant.damper())
    share = plant.rng.uniform(0.1, 0.5)
    plant.records = [r.replace(note="clipped", force=np.minimum(r.force, share * r.force.max())) for r in plant.records]
    plant.fault = ("is cut off",)


def unit(plant: Plant) -> None:
    plant.record(plant.damper())
    k = int(plant.rng.integers(len(plant.records)))
    factor = plant.rng.choice([1000.0, 4.448, 9.807]) ** plant.rng.choice([-1.0, 1.0])
    plant.records[k] = plant.records[k].replace(note="unit", force=factor * plant.records[k].force)
    plant.fault = ("the force is in another unit",)


def gas(plant: Plant) -> None:
    length = max(stroke for stroke, _ in plant.motions) * plant.rng.uniform(1.5, 4.0)
    plant.record(plant.damper("gas_spring", f0=plant.friction * plant.rng.uniform(2.0, 8.0), L=length, gamma=1.3))
    plant.fault = ("a gas spring", "a spring is missing")


def power_law(plant: Plant) -> None:
    C, alpha = 10 ** plant.rng.uniform(3.0, 4.0), plant.rng.choice([0.15, 0.3, 0.5, 1.7, 2.0])
    plant.model, plant.numbers = "power_law", {"power_law.C": C, "power_law.alpha": alpha}
    plant.record(plant.damper())
    plant.model = str(plant.rng.choice(["dahl", "bingham", "hyperbolic_tangent"]))
    plant.fault = ("a power of the velocity",)


def bleed(plant: Plant) -> None:
    numbers = {"c": plant.damping, "fy": plant.friction, "vy": 0.005}
    numbers["b"] = plant.friction / plant.rng.uniform(0.03, 0.3)
    numbers["d"] = max(stroke for stroke, _ in plant.motions) * plant.rng.uniform(0.05, 0.3)
    plant.model = "shutting_bleed"
    plant.numbers = {f"shutting_bleed.{key}": value for key, value in numbers.items()}
    plant.record(plant.damper())
    plant.model = str(plant.rng.choice(["bingham", "hyperbolic_tangent", "dahl"]))
    plant.fault = ("a bleed",)


def saturation(plant: Plant) -> None:
    key = next(name for name in plant.numbers if name in ("dahl.kw", "hyperbolic_tangent.ft"))
    knee = plant.rng.uniform(0.3, 1.0)
    for volts in np.linspace(0.0, 5.0, 5):
        plant.numbers[key] = plant.friction * (0.05 + float(np.tanh(volts / knee)))
        plant.record(plant.damper(), voltage=float(volts), motions=2)
    plant.options = {"laws": "polynomial:1"}
    plant.fault = ("do not follow the law over the input",)


PLANTED = (backlash, asymmetry, heat, delay, clipped, unit, gas, power_law, bleed, saturation)
LEAST = {clipped: 0.10}  # a viscous damper that is cut off looks like friction, which misses less


@pytest.mark.by_hand  # test_missing_effect.py has a damper of each cause
@pytest.mark.endure
def test_what_is_proposed_first_is_what_was_planted(endurance: Endurance) -> None:
    seed, wanted = 20261128, endurance.count(20)
    right = {plant.__name__: 0 for plant in PLANTED}
    for k, planted in enumerate(PLANTED):
        tries, seen = 0, 0
        while seen < wanted:  # until the model misses so much that a cause is looked for
            tries += 1
            plant = Plant(np.random.default_rng([seed, k, tries]))
            planted(plant)
            options = FitOptions(thresholds=CURIOUS, **plant.options)
            fit = dp.identification.fit(plant.records, plant.model, options)
            if np.mean([score.l1 for score in fit.scores.values()]) <= LEAST.get(planted, 0.20):
                continue
            seen += 1
            effects = list_missing_effects(fit, options)
            right[planted.__name__] += bool(effects) and any(words in effects[0].cause for words in plant.fault)
    shares = [count / wanted for count in right.values()]
    assert np.mean(shares) >= 0.8  # floor of the issue 0.8, aim 0.9
    endurance.report(
        "causes planted at random in dampers of three kinds, which a fit that misses over 20 % of the force names first",
        seed,
        f"{wanted} of each: "
        + ", ".join(f"{name.replace('_', ' ')} {100 * n / wanted:.0f} %" for name, n in right.items()),
    )
