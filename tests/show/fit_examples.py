"""Records of a known damper, of which fits are made for pages."""

from tests.identification.synthetic import sine

from dampyr.models import Damper, Interpolation
from dampyr.records import Record

VOLTS = (0.0, 1.0, 2.0)
DAHL = Damper(
    "dahl",
    {
        "dahl.kx": Interpolation(VOLTS, (800.0, 1300.0, 1800.0)),
        "dahl.kw": Interpolation(VOLTS, (50.0, 200.0, 350.0)),
        "dahl.rho": 3000.0,
    },
)


def records(volts: tuple[float, ...] = VOLTS, each: int = 2) -> list[Record]:
    return [
        sine(DAHL, u, f"{u:g}V-{k}", 0.004 + 0.002 * k, 1.3 - 0.2 * k, noise=1.0, seed=k)
        for u in volts
        for k in range(each)
    ]
