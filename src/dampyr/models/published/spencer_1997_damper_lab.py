"""Another set that is called Spencer (1997): that of a teaching simulator, with A = 58.

The equations of `spencer_1997`, in SI. A sets how large z grows, so the hysteretic force is sqrt(58/301) = 0.44 of that of
`spencer_1997`; everything else that both have is the same.
"""

from dampyr.models.damper import Damper
from dampyr.models.published._about import About, Motion
from dampyr.models.published._conversion import modified_bouc_wen

ABOUT = About(
    claims="Spencer et al. (1997)",
    paper='"Spencer 1997 / Lord RD-1005-3" (a comment in the source)',
    where="page and table not known: the paper was not read",
    read="scripts/generate_sample_data.py and README.md of github.com/waqasmbaig/MR-Damper-Lab (commit 2dbcbd1)",
    device='"Lord RD-1005-3" by the source',
    printed={
        "c0a": (2100.0, "N s/m"),
        "c0b": (350.0, "N s/(m V)"),
        "k0": (4690.0, "N/m"),
        "c1a": (28300.0, "N s/m"),
        "c1b": (295.0, "N s/(m V)"),
        "k1": (500.0, "N/m"),
        "x0": (0.0, "m"),
        "alpha_a": (14000.0, "N/m"),
        "alpha_b": (69500.0, "N/(m V)"),
        "gamma": (3.63e6, "1/m^2"),
        "beta": (3.63e6, "1/m^2"),
        "A": (58.0, "1"),
        "n": (2.0, "1"),
        "eta": (190.0, "1/s"),
    },
    limits=(0.0, 1.5),
    limits_from="the source's samples are run at 1 and 1.5 V",
    motion=Motion(amplitude=0.015, frequency=1.5, inputs=(0.0, 1.0, 1.5)),
    eta=190.0,
    notes=(
        "the source feeds the velocity through a filter of 100 Hz, which is left out here",
        "its README states, for 15 mm at 1.5 Hz and 1 V, -545.5 to +544.0 N and 27.963 J per cycle; this damper gives the "
        "same within 2 %",
    ),
    differs={
        "spencer_1997": "has A = 301 in place of 58 and x0 = 14.3 cm in place of 0",
        "spencer_1997_baig": "every number but A, n and eta differs: it cannot be the same specimen",
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
    return ABOUT.damper("modified_bouc_wen", laws)
