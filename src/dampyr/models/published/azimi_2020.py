r"""Azimi et al.: a 50 kN damper, a Bouc-Wen model linear in the voltage.

The equations of `tan_agrawal_2004`, in SI. The numbers are a tenth of that set's, except that alpha_b has its digits 6 and 9
changed over. The source says that they are borrowed from "Modeling and control of magnetorheological dampers for seismic
response reduction"; that paper was not read.
"""

from math import pi

from dampyr.models.damper import Damper
from dampyr.models.published._about import About, Motion
from dampyr.models.published._conversion import bouc_wen

ABOUT = About(
    claims="Modeling and control of magnetorheological dampers for seismic response reduction",
    paper="borrowed from “Modeling and control of magnetorheological dampers for seismic response reduction”, by the source; "
    "used in Azimi and Molaei Yeznabad (2020), Journal of Sensor and Actuator Networks 9(2), 18",
    where="page and table not known: neither paper was read",
    read="a public MATLAB script headed “Structural Dynamics and Vibration Control (M. Azimi et al.)”",
    device="a damper of 50 kN (Fmax) for simulation; no specimen is named",
    printed={
        "c0a": (44.0, "N s/m"),
        "c0b": (440.0, "N s/(m V)"),
        "alpha_a": (1087200.0, "N/m"),
        "alpha_b": (4691600.0, "N/(m V)"),
        "gamma": (300.0, "1/m^2 (sic)"),
        "beta": (300.0, "1/m^2 (sic)"),
        "A": (1.2, "1"),
        "n": (1.0, "1"),
        "eta": (50.0, "1/s"),
    },
    limits=(0.0, 5.0),
    limits_from="Vmax = 5 in the source, which runs 0, 1, 3 and 5 V",
    motion=Motion(amplitude=0.06, frequency=9.43 / (2.0 * pi), inputs=(0.0, 1.0, 3.0, 5.0)),
    eta=50.0,
    notes=(
        "the source prints 1/m^2 beside beta and gamma; with n = 1 they must be in 1/m, and are taken so",
        "the source's motion is 6 cm at 9.43 rad/s with a velocity of 40 cm/s, which do not agree (56.6 cm/s); the velocity "
        "of the displacement is taken here",
    ),
    differs={
        "tan_agrawal_2004": "has ten times c0 and alpha (1000 kN at 10 V), and 4.9616 in alpha_b where this has 4.6916",
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
