"""Stand-in for the person at a simulated rig: answers for the operator, and moves the plant as a hand does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dampyr.rig.simulation import plant
from dampyr.rig.simulation.simulator import Hand, Simulator

DURATION = 2.0  # s of a motion by hand: 10 mm at 5 mm/s
HANDS: Mapping[str, Hand] = {
    "turn out": Hand(speed=0.005),
    "turn back": Hand(speed=-0.005),
    "pull": Hand(force=60.0),
    "low switch": Hand(switch=-1),
    "high switch": Hand(switch=1),
    "stop": Hand(pressed=True),
    "voltmeter": Hand(),
}


class OperatorStandIn:
    """An operator of `dampyr.rig.bring_up` for a rig simulated in this process; ``answer`` says what is answered before a step,
    ``show`` is called with each step's outcome.
    """

    def __init__(
        self,
        simulator: Simulator,
        answer: Callable[[Any], Any] = lambda _: "go",
        show: Callable[..., None] = lambda *_: None,
    ) -> None:
        self.simulator, self.begin, self.show = simulator, answer, show
        self._action = ""

    def act(self, action: str, words: str) -> None:
        """Do it, from now on."""
        self._action = action
        self.simulator.lay_hand_on(HANDS[action])

    def done(self, seconds: float) -> str | None:
        """Let go after `DURATION`; a voltmeter's reading at once."""
        if self._action == "voltmeter":
            return f"{self.simulator.plant[plant.Y_COIL]:.3f}"
        if seconds < DURATION - 1e-9:
            return None
        self.simulator.lay_hand_on(Hand())
        return ""
