r"""Spencer, Dyke, Sain and Carlson (1997): the modified Bouc-Wen model of their prototype, linear in the voltage.

.. math:: F = c_1 \dot y + k_1 (x - x_0), \qquad (c_0 + c_1) \dot y = \alpha z + c_0 \dot x + k_0 (x - y)

.. math:: \dot z = -\gamma|\dot x - \dot y| z |z|^{n-1} - \beta(\dot x - \dot y)|z|^n + A(\dot x - \dot y)

with :math:`\alpha = \alpha_a + \alpha_b u`, and c0 and c1 likewise, and :math:`\dot u = -\eta (u - V)` behind the command V;
N, cm, s, V. The paper itself was not read: all fourteen numbers were read in a script that names no paper, and twelve of them
in another that names this one.
"""

from dampyr.models.damper import Damper
from dampyr.models.published._about import About, Motion
from dampyr.models.published._conversion import modified_bouc_wen

CM = 1e-2  # m

ABOUT = About(
    claims="Spencer et al. (1997)",
    paper="Spencer, Dyke, Sain and Carlson (1997), Phenomenological model for magnetorheological dampers, "
    "Journal of Engineering Mechanics 123(3), 230-238",
    where="page and table not known: the paper was not read",
    read="Bouc_wen_paper.m of github.com/MechEngineering/Bouc-Wen-MATLAB-model (commit a83a726), which names no paper; "
    "scripts/generate_sample_data.py of github.com/waqasmbaig/MR-Damper-Lab (commit 2dbcbd1) gives the same numbers but "
    "A and x0, and names it",
    device="prototype magnetorheological damper; its maker and type are not in what was read",
    printed={
        "c0a": (21.0, "N s/cm"),
        "c0b": (3.5, "N s/(cm V)"),
        "k0": (46.9, "N/cm"),
        "c1a": (283.0, "N s/cm"),
        "c1b": (2.95, "N s/(cm V)"),
        "k1": (5.0, "N/cm"),
        "x0": (14.3, "cm"),
        "alpha_a": (140.0, "N/cm"),
        "alpha_b": (695.0, "N/(cm V)"),
        "gamma": (363.0, "1/cm^2"),
        "beta": (363.0, "1/cm^2"),
        "A": (301.0, "1"),
        "n": (2.0, "1"),
        "eta": (190.0, "1/s"),
    },
    limits=(0.0, 2.25),
    limits_from="0 to 2.25 V were applied in the prototype's tests with random voltage (NEES-2012-1158, doi 10.4231/D3V11VM6X, "
    "as quoted by a public repository); the script runs 0, 1, 2 and 3 V",
    motion=Motion(amplitude=0.015, frequency=1.5, inputs=(0.0, 1.0, 2.0)),
    eta=190.0,
    notes=(
        "units beside the numbers: only N s/cm and N/cm are in the script; the rest follow from the equations",
        "k1 x0 is a constant -71.5 N at x = 0; a building leaves it out",
    ),
    differs={
        "spencer_1997_damper_lab": "has A = 58 in place of 301 and x0 = 0 in place of 14.3 cm",
        "spencer_1997_baig": "every number but n and eta differs: it cannot be the same specimen",
    },
)


def damper() -> Damper:
    """The damper, in SI, over the voltage."""
    p = ABOUT.numbers
    laws = modified_bouc_wen(
        ABOUT.limits,
        c0=(p["c0a"] / CM, p["c0b"] / CM),
        c1=(p["c1a"] / CM, p["c1b"] / CM),
        alpha=(p["alpha_a"] / CM, p["alpha_b"] / CM),
        k0=p["k0"] / CM,
        k1=p["k1"] / CM,
        A=p["A"],
        beta=p["beta"] / CM**2,
        gamma=p["gamma"] / CM**2,
        n=p["n"],
    )
    return ABOUT.damper("modified_bouc_wen + offset", {**laws, "offset.f0": -p["k1"] / CM * p["x0"] * CM})
