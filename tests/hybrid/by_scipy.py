"""The loop of a virtual hybrid test by scipy and plain numpy."""

import numpy as np
from scipy import signal

from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    HybridSetup,
    TransferSystem,
)
from dampyr.hybrid.setup import IDEAL
from dampyr.structures import Building

K = np.array([[26e6, -23e6, 6e6], [-23e6, 32.5e6, -14.4e6], [6e6, -14.4e6, 9.3e6]])
M = 1000.0 * np.eye(3)
RATE = 4096.0


def ideal(building: Building, **changes: object) -> HybridSetup:
    changes = {"sensors": IDEAL, "transfer": TransferSystem(max_force=np.inf)} | changes
    return HybridSetup(building, **changes)  # type: ignore[arg-type]


class ByScipy:
    """Numerical part and plant of the ideal set-up, made from the published transfer functions by scipy alone."""

    def __init__(self, building: Building, motion: GroundMotion) -> None:
        m, k, zeta = 29.13, 1.19e6, 0.0097
        c = 2 * zeta * np.sqrt(k * m)
        first = np.diag([1.0, 0.0, 0.0])
        Mn, Cn, Kn = M - m * first, building.C - c * first, K - k * first
        a = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(Mn, Kn), -np.linalg.solve(Mn, Cn)]])
        ground = np.concatenate([np.zeros(3), -np.linalg.solve(Mn, M @ np.ones(3))])[:, None]
        force = np.concatenate([np.zeros(3), -np.linalg.solve(Mn, first[:, 0])])[:, None]
        out = np.eye(6)
        self.a, self.bg, _, self.dg, _ = signal.cont2discrete((a, ground, out, np.zeros((6, 1))), 1 / RATE, "foh")
        self.af, self.bf, *_ = signal.cont2discrete((a, force, out, np.zeros((6, 1))), 1 / RATE, "zoh")
        # force from command, and displacement from force: one system with both outputs, from the polynomials
        specimen = np.array([m, c, k])
        valve, inner = np.array([1.0, 425.0, 9.9976e4]), np.array([1.0, 3.3])
        loop = np.polyadd(np.polymul(inner, specimen), [4.2297e6, 0.0])
        denominator = np.polyadd(np.polymul(valve, loop), [2.1283e13])
        # in milliseconds, in which the coefficients of these polynomials have one size
        numerators = [2.1283e13 * 1.0261 * specimen, np.array([0.0, 0.0, 2.1283e13 * 1.0261])]
        thousands = 1e3 ** np.arange(5, -1, -1)
        outputs = np.array([np.pad(each, (2, 0)) * thousands[1:] for each in numerators])
        denominator = denominator * thousands
        ap = np.eye(5, k=-1)
        ap[0] = -denominator[1:] / denominator[0]
        cp = outputs / denominator[0]
        self.ap, self.bp, self.cp, *_ = signal.cont2discrete(
            (ap, np.eye(5)[:, :1], cp, np.zeros((2, 1))), 1e3 / RATE, "zoh"
        )
        self.ground = np.interp(
            np.arange(int(motion.duration * RATE + 1e-6) + 1) / RATE, motion.time, motion.acceleration
        )

    def run(self, command: object, delay: int, extrapolation: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Floors (3, T) and the specimen's displacement (T,); ``command`` is called with target and displacement."""
        n = len(self.ground)
        by_ground, by_force, p = -self.dg * self.ground[0], np.zeros((6, 1)), np.zeros((5, 1))  # at rest
        floors, x, forces = np.zeros((3, n)), np.zeros(n), np.zeros(n + 10)
        for k in range(n):
            z = (by_ground + self.dg * self.ground[k] + by_force)[:, 0]
            force, x[k] = (self.cp @ p)[:, 0]
            floors[:, k], forces[k] = z[:3], force
            u = command(z[0], x[k])  # type: ignore[operator]
            late, before = (forces[k - d] if k >= d else 0.0 for d in (delay, delay + 1))
            held = late + extrapolation * (late - before)
            by_ground, by_force = self.a @ by_ground + self.bg * self.ground[k], self.af @ by_force + self.bf * held
            p = self.ap @ p + self.bp * u
        return floors, x


class FilterByScipy:
    """A filter sample by sample."""

    def __init__(self, numerator: np.ndarray, denominator: np.ndarray) -> None:
        self.b, self.a = numerator, denominator
        self.state = np.zeros(max(len(self.b), len(self.a)) - 1)

    def __call__(self, value: float) -> float:
        out, self.state = signal.lfilter(self.b, self.a, [value], zi=self.state)
        return float(out[0])


def agree(own: np.ndarray, other: np.ndarray, relative: float = 1e-8) -> None:
    np.testing.assert_allclose(own, other, rtol=0.0, atol=relative * np.max(np.abs(other)))
