"""A Bouc-Wen damper with a law of its exponent, which is at least one."""

from dampyr.models import Damper
from dampyr.models.damper import Law

OTHERS = {"bouc_wen.c0": 600.0, "bouc_wen.k0": 0.0, "bouc_wen.kw": 60.0, "bouc_wen.rho": 2500.0, "bouc_wen.sigma": 1.0}


def of_exponent(law: Law) -> Damper:
    """A damper whose exponent n, which is at least 1, follows ``law``."""
    return Damper("bouc_wen", OTHERS | {"bouc_wen.n": law})
