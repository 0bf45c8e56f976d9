r"""A damper of 0.5 A in a script for a building under wind: the modified Bouc-Wen model with the shape that the script runs.

.. math:: F = c_1 \dot y + f_0, \qquad (c_0 + c_1) \dot y = \alpha z + c_0 \dot x + k_0 (x - y)

.. math:: \dot z = -\beta|\dot x - \dot y| z |z|^{n-1} - \gamma(\dot x - \dot y)|z|^n + A(\dot x - \dot y)

with cubics in the current for alpha, c0 and c1; N, mm, s, A. The script notes beta = 3.044 and
gama = 0.103 in comments, and runs with the two changed over. So sigma = 0.033 and the loops bulge the wrong way, which a
warning says when the damper is made; `eldorado_as_noted` has them as in the comments.
"""

from dampyr.models.damper import Damper
from dampyr.models.published._about import About, Motion
from dampyr.models.published._conversion import modified_bouc_wen

MM = 1e-3  # m

ABOUT = About(
    claims="alexeldorado/MR-dampers",
    paper="none is named in the source",
    where="the source",
    read="MR-dampers.py of github.com/alexeldorado/MR-dampers (commit 690dcef)",
    device="not named",
    printed={
        "alpha_0": (38.24, "N/mm"),
        "alpha_1": (412.52, "N/(mm A)"),
        "alpha_2": (905.14, "N/(mm A^2)"),
        "alpha_3": (-826.67, "N/(mm A^3)"),
        "c0_0": (0.59, "N s/mm"),
        "c0_1": (11.02, "N s/(mm A)"),
        "c0_2": (10.51, "N s/(mm A^2)"),
        "c0_3": (-11.73, "N s/(mm A^3)"),
        "c1_0": (4.73, "N s/mm"),
        "c1_1": (64.57, "N s/(mm A)"),
        "c1_2": (57.03, "N s/(mm A^2)"),
        "c1_3": (-54.40, "N s/(mm A^3)"),
        "k0": (1.121, "N/mm"),
        "f0": (40.0, "N"),
        "A": (10.013, "1"),
        "beta": (0.103, "1/mm^2"),
        "gama": (3.044, "1/mm^2"),
        "nbw": (2.0, "1"),
    },
    limits=(0.0, 0.5),
    limits_from="Imax = 0.5 in the source",
    input="A",
    motion=Motion(amplitude=0.010, frequency=1.0, inputs=(0.0, 0.25, 0.5)),
    notes=(
        "the source prints no units: it turns m into mm before and takes the force in N after, the rest follows",
        "the source multiplies the force by 20 in its building; this is one damper",
        "beta multiplies the term with |v| here, unlike in spencer_1997",
        "sigma = beta/(beta + gama) = 0.033: the loops bulge the wrong way, and a warning says so",
        "the source runs no sine; the motion given here is chosen",
    ),
    differs={"eldorado_as_noted": "has beta and gama as in the comments of the source, changed over from here"},
)


def damper() -> Damper:
    """The damper, in SI, over the current."""
    p = ABOUT.numbers
    laws = modified_bouc_wen(
        ABOUT.limits,
        c0=[p[f"c0_{k}"] / MM for k in range(4)],
        c1=[p[f"c1_{k}"] / MM for k in range(4)],
        alpha=[p[f"alpha_{k}"] / MM for k in range(4)],
        k0=p["k0"] / MM,
        k1=0.0,
        A=p["A"],
        beta=p["gama"] / MM**2,  # theirs multiplies v |z|^n, as ours called beta does
        gamma=p["beta"] / MM**2,
        n=p["nbw"],
    )
    return ABOUT.damper("modified_bouc_wen + offset", {**laws, "offset.f0": p["f0"]})
