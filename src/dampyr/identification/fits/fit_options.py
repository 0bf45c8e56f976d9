"""What can be chosen in a fit, and in the search for a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.identification.parameter_uncertainty.levels import PRIOR_SESSION
from dampyr.identification.scoring.scoring_window import SETTLING
from dampyr.identification.search.variable_projection import MAX_ITERATIONS
from dampyr.models import compose
from dampyr.models.part import part
from dampyr.options import FormGroup, Options, ShownIn, Terminal
from dampyr.units import Quantity

SEARCH, CHOICE = FormGroup("Search"), FormGroup("Choice of a model")
BUDGET = 480.0  # counted s: two cores take four minutes for it, with what compiles and the last fits five
ADD_ONS = (
    "compliance",
    "spring",
    "place_friction",
    "delay",
    "lag",
)  # tried in this order: what matters most comes before work is short
FINALISTS = 5  # each costs a fit and two cross-validations of all records

LOSSES = Choices(
    {
        "squares": "least squares",
        "huber": "Huber: robust against outliers",
        "l1": "L1: robust against outliers",
    }
)
WEIGHTINGS = Choices(
    {
        "records": "every record the same, however long",
        "samples": "every sample the same: long records count more",
    }
)
SPLITS = Choices(
    {
        "record": "random parts of the records",
        "input": "one input left out at a time, except the outer ones",
        "frequency": "parts in the order of frequency",
        "amplitude": "parts in the order of stroke",
        "waveform": "one kind of motion left out",
        "time": "the last 40 % of every motion",
    }
)
NUISANCES = Choices(
    {
        "offset": "an offset of the force",
        "state": "the hysteretic states at the start",
        "gain": "a factor on the whole force",
        "temperature": "a factor on every parameter in N s/m",
    }
)


@dataclass(frozen=True)
class FitOptions(Options):
    """Options of `fit`; those that choose a model are of a fit without one.

    ``thresholds`` say from which value on something is a finding; they change no number of a fit.
    """

    laws: Annotated[
        str | Mapping[str, str] | None,
        Terminal("--law", "[NAME=]KIND"),
        "How parameters follow the input, all or by name: constant, interpolation (as without it), polynomial:DEGREE; "
        "with +temperature also the mean temperature of the records",
    ] = None
    fixed: Annotated[
        Mapping[str, float], Terminal("--fix", "NAME=VALUE"), "Parameters that are held at a value, in SI units"
    ] = field(default_factory=dict)
    tied: Annotated[
        Mapping[str, str],
        Terminal("--tie", "NAME=OTHER"),
        "Parameters that take the law of another one of the same unit",
    ] = field(default_factory=dict)
    bandwidth: Annotated[
        float | None,
        Quantity("Hz", low=0, open_low=True),
        "Bandwidth of the velocity that is derived from the displacement; without it the recorded velocity where there is one",
    ] = None
    loss: Annotated[str, LOSSES, "What is minimised; huber and l1 are robust against outliers"] = "squares"
    weighting: Annotated[str, WEIGHTINGS, "Whether every record or every sample counts the same in a fit"] = "records"
    nuisances: Annotated[
        tuple[str, ...],
        NUISANCES,
        Terminal("--nuisance", adds=True),
        "What else is fitted in each record, which describes the record and not the damper; gain and temperature need two "
        "records at each input",
    ] = ("offset", "state")
    settling: Annotated[float, Quantity("s", low=0), "Time after the motion starts that is not scored"] = SETTLING
    predict: Annotated[tuple[str, ...], SPLITS, "How records are left out and predicted"] = ()
    folds: Annotated[int, Quantity("", low=2), "Parts into which records are split to be predicted"] = 5
    session_prior: Annotated[
        float,
        Quantity("", low=0, high=1),
        ShownIn("%"),
        "How much the force differs from one measurement session to another, where the records do not tell (standard "
        "deviation of the level)",
    ] = PRIOR_SESSION
    mixed_origins: Annotated[bool, "Fit simulated or virtual records together with others"] = False
    starts: Annotated[
        int | None,
        SEARCH,
        Quantity("", low=1),
        "Number of starting points of the search; without it one, but 30 with force_table and 10 with triple_pendulum "
        "(trials of a choice of models: one)",
    ] = None
    seed: Annotated[
        int, SEARCH, Quantity("", low=0), "Seed of random starting points and of random parts of the records"
    ] = 0
    steps: Annotated[
        int, SEARCH, Quantity("", low=1), "Steps that the search may take; trials of a choice of models take 15"
    ] = MAX_ITERATIONS
    seconds: Annotated[
        float | None,
        SEARCH,
        Quantity("s", low=0, open_low=True),
        "End the search after this time; a choice of models that was cut chooses none",
    ] = None
    budget: Annotated[
        float | None,
        SEARCH,
        Quantity("s", low=0, open_low=True),
        f"Work that the search may take, counted and not timed, about s of one core; without it {BUDGET:g} s for a choice of "
        "models, and no limit for one model",
    ] = None
    models: Annotated[
        tuple[str, ...],
        CHOICE,
        Terminal("--try", "MODEL"),
        "Without a model: only these are tried, not the whole catalogue",
    ] = ()
    add_ons: Annotated[
        tuple[str, ...], CHOICE, Terminal("--add-on", "PART"), "Without a model: the parts that are tried in addition"
    ] = ADD_ONS
    finalists: Annotated[
        int, CHOICE, Quantity("", low=1), "Without a model: how many are fitted to all records, at most"
    ] = FINALISTS
    nested: Annotated[
        bool,
        CHOICE,
        "Without a model: repeat the choice five times without a fifth of the records, and predict that fifth",
    ] = False
    yardstick: Annotated[
        bool,
        CHOICE,
        "Without a model: train black boxes on the same parts of the records and say what they see that no model does "
        "(needs dampyr[yardstick])",
    ] = False
    thresholds: FitThresholds = field(default_factory=FitThresholds)

    def check(self) -> None:
        """Refuse what is not the name of a model or a part."""
        for model in self.models:
            compose(model)
        for name in self.add_ons:
            if not part(name).add_on:
                raise InputError(f"add_ons: {name} is not an add-on; choose from {', '.join(ADD_ONS)}")

    def check_of_model(self, model: object) -> None:
        """Refuse a model that does not exist, what needs a model where there is none, and what excludes one."""
        if isinstance(model, str):
            compose(model)
        if model is None and (self.fixed or self.tied):
            raise InputError(
                "fixed and tied parameters need a model: without one every model is tried; name one, such as dahl"
            )
        if model is not None and self.models:
            raise InputError(
                "the models to try and a model exclude each other; name the models to try, or the one to fit"
            )
