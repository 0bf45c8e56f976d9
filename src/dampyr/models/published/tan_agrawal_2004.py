r"""Tan and Agrawal (2004): the 1000 kN damper of the highway-crossing benchmark, a Bouc-Wen model linear in the voltage.

.. math:: F = c_0 v + \alpha z, \qquad \dot z = -\gamma|v| z |z|^{n-1} - \beta v|z|^n + A v

with :math:`c_0 = c_{0a} + c_{0b} u` and :math:`\alpha = \alpha_a + \alpha_b u`; N, m, s, V ("METRIC SYSTEM : N - m - s" in the
benchmark's input file). beta = gamma, so it does not matter which of the two letters multiplies the term with \|v\|.
"""

from math import pi

from dampyr.models.damper import Damper
from dampyr.models.published._about import About, Motion
from dampyr.models.published._conversion import bouc_wen

ABOUT = About(
    claims="the highway-crossing benchmark (2004)",
    paper="Benchmark Control Problem for Seismic Response of Highway Crossing, City College of New York, October 2004; coded "
    "by Ping Tan, supervised by Anil K. Agrawal",
    where="the benchmark's file DEVICE DATA, section “Parameters for MR dampers”",
    read="that file, and the benchmark's files of the input and of the semiactive sample controller, as a public repository "
    "holds them",
    device="a damper of 1000 kN (Max_for) for simulation; no specimen is named",
    printed={
        "c0a": (4.40e2, "N s/m"),
        "c0b": (44.0e2, "N s/(m V)"),
        "alpha_a": (1.0872e7, "N/m"),
        "alpha_b": (4.9616e7, "N/(m V)"),
        "gamma": (300.0, "1/m"),
        "beta": (300.0, "1/m"),
        "A": (1.2, "1"),
        "n": (1.0, "1"),
        "eta": (50.0, "1/s"),
    },
    limits=(0.0, 10.0),
    limits_from="Umax = 10 in the benchmark's semiactive sample controller",
    motion=Motion(amplitude=0.06, frequency=9.43 / (2.0 * pi), inputs=(0.0, 5.0, 10.0)),
    eta=50.0,
    notes=(
        "n = 1 is not in the files that were read: it is that of azimi_2020, and makes 300 a number in 1/m and the force at "
        "10 V reach the 1000 kN of the file",
        "the files run no sine; the motion given here is that of azimi_2020",
    ),
    differs={
        "azimi_2020": "has a tenth of c0 and of alpha (100 kN at 10 V), and 4.6916 in alpha_b where this has 4.9616",
    },
)


def damper() -> Damper:
    """The damper, in SI as printed, over the voltage."""
    p = ABOUT.numbers
    laws = bouc_wen(
        ABOUT.limits,
        c0=(p["c0a"], p["c0b"]),
        alpha=(p["alpha_a"], p["alpha_b"]),
        A=p["A"],
        beta=p["beta"],
        gamma=p["gamma"],
        n=p["n"],
    )
    return ABOUT.damper("bouc_wen", laws)
