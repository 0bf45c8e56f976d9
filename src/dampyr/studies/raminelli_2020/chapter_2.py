"""Chapter 2: the Bouc-Wen loop of Fig. 2.2, and the numerical example of section 2.4 with Figs. 2.3 and 2.4."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import limit_cycle
from dampyr.identification.limit_cycle_methods.limit_cycle import LimitCycle
from dampyr.models import Damper
from dampyr.models.parts.bouc_wen import from_printed
from dampyr.show.figures.history import history
from dampyr.show.figures.phase_portrait import phase_portrait
from dampyr.show.figures.style import DISPLACEMENT, HALF, Axis
from dampyr.show.figures.theta import theta
from dampyr.show.pages.blocks import FigureBlock, Text
from dampyr.studies._compared_value import (
    AlternativeValue,
    ComparedValue,
    ComparisonTolerance,
    Erratum,
    judge,
    unchecked,
)
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.published import BoucWenLetters, Example, Published
from dampyr.studies.raminelli_2020.study_part import StudyPart

Array = NDArray[np.float64]
DT = 1.25e-4  # s; the sampling that the velocities of Step 2 imply, tested below
MILLIONTH = ComparisonTolerance(relative=1e-6)
GREEK = {"alpha": "α", "beta": "β", "gamma": "γ", "A": "A", "n": "n"}
PICTURE = "the text has the caption only, its figure is a picture; ours is drawn anew"


def chapter_2(published: Published) -> StudyPart:
    """Figs. 2.2 to 2.4 and the example of section 2.4."""
    loop = bouc_wen_loop(published.bouc_wen)
    figure_values, erratum, block = figure_2_2(published.bouc_wen, loop)
    sampled = Branch.of(published.example, 0.0)
    exact = limit_cycle(sampled.x, sampled.force, sampled.velocity)
    judged = [*figure_values, *step_2(published.example, sampled), *example(published.example, exact)]
    judged += [unchecked(f"Figure {k}", "the curve", None, "", PICTURE) for k in ("2.2", "2.3", "2.4")]
    blocks = [block, *_example_figures(published.example, sampled, exact), compared_table(judged)]
    return StudyPart("Chapter 2: the method on numbers", judged, blocks, [erratum, _zero_by_zero(sampled)])


@dataclass(frozen=True)
class BoucWenLoop:
    """A Bouc-Wen loop in the printed letters' own unit of x: x, z (n,), and z with every time halved."""

    x: Array
    z: Array
    z_fast: Array
    t: Array


def bouc_wen_loop(letters: BoucWenLetters) -> BoucWenLoop:
    """Three cycles of a sine long enough to saturate: alpha z is the force of a Bouc-Wen part without spring and dashpot."""
    shape = {name: float(getattr(letters, name)) for name in ("alpha", "A", "beta", "gamma", "n")}
    model = from_printed(c0=0.0, k0=0.0, **shape)
    names = ("c0", "k0", "kw", "rho", "sigma", "n")
    damper = Damper("bouc_wen", {f"bouc_wen.{name}": getattr(model, name) for name in names})
    t = np.linspace(0.0, 3.0, 12_001)
    x = 8.0 / model.rho * np.sin(2 * np.pi * t)
    z, fast = (damper.force(times, x, voltage=0.0) / float(letters.alpha) for times in (t, 0.5 * t))
    return BoucWenLoop(x, z, fast, t)


def figure_2_2(letters: BoucWenLetters, loop: BoucWenLoop) -> tuple[list[ComparedValue], Erratum, FigureBlock]:
    """The largest z against the closed form of the printed letters, and what (2.1) as printed would mean."""
    last = slice(2 * loop.t.size // 3, None)
    limit = float(letters.A / (letters.beta + letters.gamma)) ** (1.0 / float(letters.n))
    largest = float(np.max(np.abs(loop.z[last])))
    quantity = "largest z of the loop; published: (A/(β+γ))^(1/n) of the printed letters"
    value = judge("Figure 2.2", quantity, limit, largest, "", ComparisonTolerance(relative=1e-5))
    speed = [float(np.max(np.abs(np.gradient(z, t)))) for z, t in ((loop.z, loop.t), (loop.z_fast, 0.5 * loop.t))]
    same = float(np.max(np.abs(loop.z_fast - loop.z)))
    erratum = Erratum(
        "(2.1)",
        "α dz/dt",
        "α z",
        f"run twice as fast along the same path, z changes by {same:.1g} and the largest dz/dt "
        f"{speed[1] / speed[0]:.3f} times: "
        "a hysteretic force that does not depend on the speed needs α z, and only α z has the unit of the other terms",
    )
    z = Axis("hysteretic state z", "unit of x")
    figure = phase_portrait(
        Axis("displacement x", "unit of x"), z, {"(2.2)": (loop.x, loop.z)}, {"(A/(β+γ))^(1/n)": limit}, share=HALF
    )
    letters_text = ", ".join(f"{name} = {getattr(letters, key).text}" for key, name in GREEK.items())
    return [value], erratum, FigureBlock(figure, f"Figure 2.2 again: {letters_text}.")


@dataclass(frozen=True)
class Branch:
    """Section 2.4 sampled: the loading branch (n,), SI, its first sample ``phase`` samples after the lower turning point."""

    t: Array
    x: Array
    velocity: Array
    force: Array

    @classmethod
    def of(cls, example: Example, phase: float) -> Branch:
        """Forward-difference velocities, one whole cycle before the branch."""
        half = round(0.5 / float(example.frequency) / DT)
        omega, amplitude = 2 * np.pi * float(example.frequency), 1e-2 * float(example.amplitude)
        t = (np.arange(3 * half + 1) + phase) * DT
        x = -amplitude * np.cos(omega * t)
        velocity = (-amplitude * np.cos(omega * (t + DT)) - x) / DT
        force = example_damper(example).force(t, x, voltage=0.0, velocity=velocity)
        rising = slice(2 * half, 3 * half)
        return cls(*(np.asarray(values[rising]) for values in (t, x, velocity, force)))


def example_damper(example: Example) -> Damper:
    """The damper of Step 1, SI."""
    return Damper(
        "dahl", {"dahl.kx": 100 * float(example.kx), "dahl.kw": float(example.kw), "dahl.rho": 100 * float(example.rho)}
    )


def step_2(example: Example, branch: Branch) -> list[ComparedValue]:
    """The forces and velocities at the ends of the branch; T+ is the sample whose velocity is nearest to the printed one."""
    k = branch.x.size - 8 + int(np.argmin(np.abs(100 * branch.velocity[-8:] - float(example.velocity_T))))
    before = branch.x.size - k
    at_T = f"at T+, {before} samples before the largest displacement"
    kx = (branch.force[0] + branch.force[k]) / (branch.velocity[0] + branch.velocity[k]) / 100
    where = "Section 2.4, step 2"
    return [
        judge(
            where,
            f"velocity at 0, forward difference, {1e3 * DT:g} ms",
            example.velocity_0,
            100 * branch.velocity[0],
            "cm/s",
        ),
        judge(where, f"velocity {at_T}", example.velocity_T, 100 * branch.velocity[k], "cm/s"),
        judge(where, "force at 0", example.force_0, branch.force[0], "N"),
        judge(where, f"force {at_T}", example.force_T, branch.force[k], "N"),
        judge(where, "kx by (2.5), from those four", example.kx_identified, kx, "N s/cm"),
    ]


def example(example: Example, exact: LimitCycle) -> list[ComparedValue]:
    """Steps 3 to 5: as the method should give them, and as the nearest sample gives them."""
    steps, a = "Section 2.4, steps 3 to 5", float(example.kw) * float(example.rho)
    return [
        judge("Figure 2.4", "x* where θ = 0", example.x_star, 100 * exact.x_star, "cm"),
        judge(steps, "a = kw ρ of Step 1, recovered", a, exact.a / 100, "N/cm", MILLIONTH),
        judge(steps, "ρ of Step 1, recovered", example.rho, exact.rho / 100, "1/cm", MILLIONTH),
        judge(steps, "kw of Step 1, recovered", example.kw, exact.kw, "N", MILLIONTH),
        *as_published(steps, example, exact),
    ]


def as_published(steps: str, example: Example, exact: LimitCycle) -> list[ComparedValue]:
    """The printed a, rho and kw: exact, and from the nearest sample with its phase chosen to meet the printed rho alone."""
    phases = np.arange(50) / 50
    trials = [_cycle_of_nearest_samples(example, phase) for phase in phases]
    phase = _phase_of_printed_rho(example, phases, trials)
    tuned = _cycle_of_nearest_samples(example, phase)
    slopes = [trial.a / 100 for trial in trials]
    low, high = min(slopes), max(slopes)
    side = "inside" if low <= example.a <= high else "outside"
    band = f"by the nearest sample a lies in {low:.5g} to {high:.5g} N/cm, as the sampling falls; the printed one is {side}"
    shift = f"with the first sample {phase:.3f} of an interval after the turning point"
    at_a = [
        AlternativeValue(
            tuned.a / 100, f"that of the sample nearest to θ = 0, {shift}, which also gives the printed ρ; {band}"
        )
    ]
    at_rho = [AlternativeValue(tuned.rho / 100, f"that of the sample nearest to θ = 0, {shift} (chosen for it)")]
    none = f"no phase of the sampling gives it; {band}"
    judged = (
        ("a of Step 4", example.a, exact.a, tuned.a, "N/cm", at_a),
        ("ρ of Step 5", example.rho_identified, exact.rho, tuned.rho, "1/cm", at_rho),
    )
    by_sample = "from the sample nearest to θ = 0, x*1 as printed"
    return [
        *(
            judge(steps, f"{name}, exact", p, e / 100, unit, candidates=c, otherwise=none)
            for name, p, e, _, unit, c in judged
        ),
        judge(
            steps, f"a of Step 4, {by_sample}, phase chosen to meet ρ", example.a, tuned.a / 100, "N/cm", otherwise=none
        ),
        judge(steps, f"kw of Step 5, {by_sample}", example.kw_identified, tuned.kw, "N"),
    ]


def _cycle_of_nearest_samples(example: Example, phase: float) -> LimitCycle:
    """The published way: the nearest samples; kx as known from Step 2."""
    branch = Branch.of(example, phase)
    near = slice(0, int(np.searchsorted(branch.x, 1e-2 * float(example.x_star1))) + 8)
    at = 1e-2 * float(example.x_star1)
    kx = 100 * float(example.kx)
    return limit_cycle(branch.x[near], branch.force[near], branch.velocity[near], kx=kx, x_star1=at, nearest=True)


def _phase_of_printed_rho(example: Example, phases: Array, trials: list[LimitCycle]) -> float:
    """The phase at which the nearest sample gives the rho nearest to the printed one."""

    def gap(phase: float, cycle: LimitCycle | None = None) -> float:
        return (cycle or _cycle_of_nearest_samples(example, phase)).rho / 100 - float(example.rho_identified)

    gaps = np.array([gap(phase, trial) for phase, trial in zip(phases, trials, strict=True)])
    best = float(phases[np.argmin(np.abs(gaps))])
    for k in np.flatnonzero(np.sign(gaps[:-1]) != np.sign(gaps[1:])):
        low, high = float(phases[k]), float(phases[k + 1])
        for _ in range(16):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if np.sign(gap(middle)) == np.sign(gaps[k]) else (low, middle)
        if abs(gap(low)) < abs(gap(best)):
            best = low
    return best


def _example_figures(example: Example, branch: Branch, exact: LimitCycle) -> list[FigureBlock | Text]:
    second = 1e-2 * float(example.x_star1)
    marks = {"x*": (exact.x_star, 0.0), "x*1 as printed": (second, float(np.interp(second, exact.x, exact.theta)))}
    omega, amplitude = 2 * np.pi * float(example.frequency), 1e-2 * float(example.amplitude)
    t = np.linspace(0.0, 2.0 / float(example.frequency), 4001)
    x, v = -amplitude * np.cos(omega * t), amplitude * omega * np.sin(omega * t)
    force = example_damper(example).force(t, x, voltage=0.0, velocity=v)
    return [
        FigureBlock(history(t, x, axis=DISPLACEMENT, share=HALF), "Figure 2.3 again: the displacement (input)."),
        FigureBlock(history(t, force, share=HALF), "Figure 2.3 again: the force (output) of (2.3) and (2.4)."),
        FigureBlock(
            theta(exact.x, exact.theta, marks, share=HALF), "Figure 2.4 again: θ on the rising branch, x* and x*1."
        ),
    ]


def _zero_by_zero(branch: Branch) -> Erratum:
    fast = float(np.max(np.abs(branch.velocity)))
    return Erratum(
        "(2.5)",
        "kx = (F(0) + F(T+)) / (v(0) + v(T+))",
        "kx known from elsewhere, such as the plastic region (4.1)",
        "for a sine both velocities are zero at the turning points: 0/0. Step 2 works on what finite differences leave, "
        f"{100 * branch.velocity[0]:.3g} cm/s, {abs(branch.velocity[0]) / fast:.1g} of the peak speed",
    )
