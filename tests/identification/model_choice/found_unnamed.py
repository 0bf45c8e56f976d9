"""Six noise-free sines of each part, and what a search of models that is told no name makes of them.

``python -m tests.identification.model_choice.found_unnamed [PART ...]`` prints a line for each part.
"""

import sys
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

from tests.models.parts import (
    test_asymmetric_bouc_wen,
    test_bilinear,
    test_bouc_wen_baber_noori,
    test_choi_polynomial,
    test_force_table,
    test_gamota_filisko,
    test_generalised_maxwell,
    test_hardening_bouc_wen,
    test_modified_bouc_wen,
    test_shutting_bleed,
    test_triple_pendulum,
)
from tests.models.parts.found_again import six_sines

from dampyr.errors import DampyrWarning
from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.models.parts import modified_bouc_wen

L1, NUMBER = 1e-3, 0.01  # what is allowed of the L1 ratio of any record, and of any number
DAHL = {"kx": 700.0, "kw": 100.0, "rho": 1500.0}
#: a part, and its numbers
PARTS: dict[str, Mapping[str, float]] = {
    "asymmetric": {"ce": 700.0, "cc": 300.0, "fe": 60.0, "fc": 40.0, "v0": 0.01},
    "asymmetric_bouc_wen": test_asymmetric_bouc_wen.NUMBERS,
    "bilinear": test_bilinear.NUMBERS,
    "bingham": {"c0": 700.0, "fc": 60.0, "v0": 0.01},
    "biviscous": {"c": 700.0, "fy": 60.0, "vy": 0.02},
    "bouc_wen": {"c0": 700.0, "k0": 900.0, "kw": 150.0, "rho": 400.0, "sigma": 0.7, "n": 1.6},
    "bouc_wen_baber_noori": test_bouc_wen_baber_noori.NUMBERS,
    "choi_polynomial": test_choi_polynomial.NUMBERS,
    "dahl": DAHL,
    "force_table": test_force_table.WIDTHS | test_force_table.RISES,
    "gamota_filisko": test_gamota_filisko.NUMBERS,
    "generalised_maxwell": test_generalised_maxwell.NUMBERS,
    "hardening_bouc_wen": test_hardening_bouc_wen.NUMBERS | {"n": 2.0},
    "hyperbolic_tangent": {"c": 700.0, "ft": 60.0, "v0": 0.02, "s": 4.0},
    "hysteretic_biviscous": {"c": 700.0, "fy": 60.0, "vy": 0.02, "vh": 0.01},
    "lugre": {"fc": 60.0, "sigma1": 200.0, "sigma2": 700.0, "rho": 1500.0, "e": 0.4, "vs": 0.02},
    "maxwell_slip": {"kx": 700.0, "kw": 100.0, "rho": 500.0},
    "modified_bouc_wen": vars(modified_bouc_wen.from_printed(test_modified_bouc_wen.SOFT)),
    "power_law": {"C": 400.0, "alpha": 0.4},
    "shutting_bleed": test_shutting_bleed.NUMBERS,
    "sigmoid": {"ft": 60.0, "c": 700.0, "vk": 0.02, "vh": 0.003},
    "triple_pendulum": vars(test_triple_pendulum.SOFT),
}
#: add-ons that the search tries, beside `dahl`
ADD_ONS: dict[str, Mapping[str, float]] = {
    "compliance": {"s": 1e-6},
    "delay": {"tau": 0.004},
    "place_friction": {"g": 10.0, "y0": 0.004, "ell": 0.03, "vf": 0.002},
    "spring": {"k0": 5000.0},
}
#: parts that the search does not try unless they are named: add-ons, of which `missing_effect` looks for some
NOT_FOUND = ("direction_factor", "free_play", "gas_spring", "inertia")
#: add-ons that six sines at one input cannot show: a constant force is an offset of each record, and nothing lags
NOT_SHOWN = ("lag", "offset")


@dataclass(frozen=True)
class Result:
    """What a search has chosen: its greatest L1 ratio of a record, and the worst of the numbers with its error."""

    name: str
    model: str
    l1: float
    error: float
    worst: str
    seconds: float

    @property
    def found(self) -> bool:
        return self.l1 < L1 and self.error < NUMBER

    def __str__(self) -> str:
        return (
            f"{self.name}: {'found' if self.found else 'NOT found'}, {self.model}, L1 {100 * self.l1:.3f} %, "
            f"{self.worst} {100 * self.error:.3f} % off, {self.seconds:.0f} s of CPU time"
        )


def numbers_of(name: str) -> dict[str, float]:
    """The numbers of a part, or of `dahl` with an add-on, by flat name."""
    parts = {name: PARTS[name]} if name in PARTS else {"dahl": DAHL, name: ADD_ONS[name]}
    return {f"{part}.{key}": value for part, numbers in parts.items() for key, value in numbers.items()}


def known(numbers: Mapping[str, float]) -> dict[str, float]:
    """The numbers that the sines can tell: of the last row of a table its slopes, and no stop that is not reached."""
    seen = {name: value for name, value in numbers.items() if name != "triple_pendulum.d3"}
    if "force_table.w6" in seen:
        width = seen.pop("force_table.w6")
        seen |= {f"force_table.{side}6": seen[f"force_table.{side}6"] / width for side in "ec"}
    return seen


def search_unnamed(name: str) -> Result:
    """The search of models on six sines of a part."""
    truth = numbers_of(name)
    records = six_sines(Damper(list(dict.fromkeys(key.partition(".")[0] for key in truth)), truth))
    begun = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        result = fit(records, progress=lambda *_: None)
    seconds = time.process_time() - begun
    found = known(result.parameters)
    errors = {key: abs(found.get(key, float("inf")) / value - 1.0) for key, value in known(truth).items()}
    worst = max(errors, key=lambda key: errors[key])
    assert result.leaderboard is not None
    l1 = max(score.l1 for score in result.scores.values())
    return Result(name, result.leaderboard.winner.model, l1, errors[worst], worst, seconds)


if __name__ == "__main__":
    for wanted in sys.argv[1:] or [*PARTS, *ADD_ONS]:
        print(search_unnamed(wanted), flush=True)
