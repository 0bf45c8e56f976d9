"""What a fit can be asked for, and what it refuses."""

import pytest
from tests.identification.fitted_numbers import gained
from tests.identification.synthetic import DAHL, sine

from dampyr.errors import InputError
from dampyr.identification import FitOptions, fit
from dampyr.identification.scoring.validation import cross_validate


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tied": {"dahl.q": "dahl.kw"}}, r"tied names 'dahl\.q'; dahl \+ spring has"),
        ({"tied": {"dahl.kw": "dahl.q"}}, r"tied names 'dahl\.q'"),
        ({"tied": {"dahl.kw": "dahl.kx"}}, "are in N and N s/m; only parameters of the same unit"),
        ({"tied": {"dahl.kw": "dahl.kw"}}, "tied itself"),
        ({"tied": {"dahl.kw": "dahl.kx", "dahl.kx": "dahl.kw"}}, "tied itself"),
        ({"tied": {"dahl.kw": "dahl.kx"}, "fixed": {"dahl.kw": 3.0}}, "fixed and tied"),
        ({"loss": "cubes"}, "loss = 'cubes' is not known; did you mean 'huber'\\? choose from squares, huber, l1"),
        (
            {"nuisances": ("offset", "weather")},
            "nuisances = 'weather' is not known; choose from offset, state, gain, temperature",
        ),
        ({"nuisances": ("gain",)}, "only record at 0 V, so its gain cannot be distinguished"),
        ({"starts": 0}, "starts = 0 is not allowed"),
    ],
)
def test_options_that_cannot_be_are_refused(options: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        fit(sine(DAHL, 0.0), "dahl + spring", **options)


def test_cross_validation_takes_the_same_options() -> None:
    records = gained([1.0, 1.02, 0.98, 1.0, 1.01, 0.99], [1.0] * 6)
    done = cross_validate(
        records, "dahl", options=FitOptions(folds=2, loss="huber", nuisances=("offset", "state", "gain"), starts=2)
    )
    assert max(s.l1 for s in done.scores.values()) < 0.06
