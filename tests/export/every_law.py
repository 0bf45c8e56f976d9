"""A damper of many parts with every kind of law, which the tests of all exports write."""

from dampyr.models import Damper, Interpolation, Polynomial


def everything() -> Damper:
    """A damper of many parts with every kind of law."""
    return Damper(
        "bouc_wen + hyperbolic_tangent + spring + delay + offset",
        {
            "bouc_wen.c0": Polynomial((500.0, 20.0), 0, 3),
            "bouc_wen.k0": 100.0,
            "bouc_wen.kw": Polynomial((300.0, 100.0, -10.0), 0, 3),
            "bouc_wen.rho": 2000.0,
            "bouc_wen.sigma": 1.3,
            "bouc_wen.n": Interpolation((0.0, 1.0, 3.0), (1.3, 1.5, 2.2)),
            "hyperbolic_tangent.c": 3.0,
            "hyperbolic_tangent.ft": Interpolation((0.0, 1.0, 2.0, 3.0), (100.0, 150.0, 190.0, 200.0)),
            "hyperbolic_tangent.v0": 0.01,
            "hyperbolic_tangent.s": -0.3,
            "spring.k0": -200.0,
            "delay.tau": Polynomial((0.005, 0.001), 0, 3),
            "offset.f0": 30.0,
        },
    )
