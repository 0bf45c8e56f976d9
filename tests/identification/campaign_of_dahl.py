"""Sines at four voltages with laws of Dahl's model over them."""

from tests.identification.synthetic import sine

from dampyr.models import Damper, Interpolation, Polynomial
from dampyr.records import Record

VOLTS = (0.0, 1.0, 2.0, 3.0)

TRUTH = {
    "dahl.kx": Polynomial((800.0, 500.0, 100.0), 0.0, 3.0),
    "dahl.kw": Interpolation(VOLTS, (50.0, 210.0, 380.0, 560.0)),
    "dahl.rho": Polynomial((4000.0, -700.0), 0.0, 3.0),
}


def campaign(damper: Damper, noise: float = 0.0, per_voltage: int = 2) -> list[Record]:
    return [
        sine(damper, u, f"{u:g}V-{k}", 0.004 + 0.003 * k, 1.2 - 0.2 * k, noise, offset=100.0 + 7 * k, seed=10 * i + k)
        for i, u in enumerate(VOLTS)
        for k in range(per_voltage)
    ]
