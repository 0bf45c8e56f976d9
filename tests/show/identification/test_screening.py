"""What the screening of a model shows: its trials, the bare one first."""

import math

from dampyr.identification.model_choice.screening import Screened, Trial
from dampyr.show.descriptions import description_of

TRIALS = (
    Trial("dahl", 0.125, 0.5),
    Trial("dahl + spring", 0.08, 1.25),
    Trial("dahl + lag", math.inf, 0.1, "no damper"),
)


def test_the_best_of_the_trials_is_named_and_each_has_a_row() -> None:
    description = description_of(Screened("dahl", TRIALS))
    assert dict(description.rows) == {"bare": "12.5 %", "best": "8 %, dahl + spring", "tried": "3 compositions"}
    [table] = [make() for make in description.tables]
    assert [list(row) for row in table.rows] == [
        ["dahl", 12.5, 0.5, ""], ["dahl + spring", 8.0, 1.25, ""], ["dahl + lag", math.inf, 0.1, "no damper"],
    ]  # fmt: skip
    assert table.heads == ["model", "validation error [%]", "time [s]", "reason"]
