"""A third set that is called Spencer (1997), with other numbers throughout: a vehicle's damper, by its size.

The equations of `spencer_1997`, in SI. gamma multiplies the term with |v| and is small, so sigma = 0.062 and the loops bulge
the wrong way: a warning says so when the damper is made. Another repository of the same author writes the two letters the other
way round, which with these numbers would give sigma = 0.938.
"""

from dampyr.models.damper import Damper
from dampyr.models.published._about import About, Motion
from dampyr.models.published._conversion import modified_bouc_wen

ABOUT = About(
    claims="Spencer et al. (1997)",
    paper="Spencer et al. (1997), by the README of the source: “identified from experimental prototype validation”",
    where="page and table not known: the paper was not read, and is probably not where these numbers come from",
    read="README.md and python/mr_damper.py of github.com/waqasmbaig/MRD-Modified-Bouc-Wen-Model (commit 4c687b3); the "
    "same numbers, as a second set, in Bouc_wen_paper.m of github.com/MechEngineering/Bouc-Wen-MATLAB-model (commit a83a726)",
    device="not named",
    printed={
        "c0a": (784.0, "N s/m"),
        "c0b": (1803.0, "N s/(m V)"),
        "k0": (3610.0, "N/m"),
        "c1a": (14649.0, "N s/m"),
        "c1b": (34622.0, "N s/(m V)"),
        "k1": (840.0, "N/m"),
        "x0": (0.0245, "m"),
        "alpha_a": (12441.0, "N/m"),
        "alpha_b": (38430.0, "N/(m V)"),
        "gamma": (136320.0, "1/m^2"),
        "beta": (2059020.0, "1/m^2"),
        "A": (58.0, "1"),
        "n": (2.0, "1"),
        "eta": (190.0, "1/s"),
    },
    limits=(0.0, 2.0),
    limits_from="the source runs 0 to 2 V",
    motion=Motion(amplitude=0.008, frequency=10.0, inputs=(0.0, 1.0, 2.0)),
    eta=190.0,
    notes=(
        "sigma = gamma/(beta + gamma) = 0.062: the loops bulge the wrong way, and a warning says so",
        "with beta and gamma the other way round, as another repository of the same author (MR-Damper-Lab) writes the "
        "equation, sigma would be 0.938",
        "the README states peaks of 414 N at 0 V and 2511 N at 2 V for 8 mm at 10 Hz",
    ),
    differs={
        "spencer_1997": "every number but n and eta differs: it cannot be the same specimen",
        "spencer_1997_damper_lab": "every number but A, n and eta differs: it cannot be the same specimen",
    },
)


def damper() -> Damper:
    """The damper, in SI as printed, over the voltage."""
    p = ABOUT.numbers
    laws = modified_bouc_wen(
        ABOUT.limits,
        c0=(p["c0a"], p["c0b"]),
        c1=(p["c1a"], p["c1b"]),
        alpha=(p["alpha_a"], p["alpha_b"]),
        k0=p["k0"],
        k1=p["k1"],
        A=p["A"],
        beta=p["beta"],
        gamma=p["gamma"],
        n=p["n"],
    )
    return ABOUT.damper("modified_bouc_wen + offset", {**laws, "offset.f0": -p["k1"] * p["x0"]})
