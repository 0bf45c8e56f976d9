"""Requests of the Identify page, and the options of the jobs that they mean."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from dampyr.identification import IdentifyOptions, ValidateOptions
from dampyr.identification.parameter_uncertainty.levels import PRIOR_SESSION
from dampyr.identification.scoring.prediction_band import LEVEL
from dampyr.identification.scoring.scoring_window import SETTLING

Keys = Annotated[list[str], Field(min_length=1, max_length=200, description="Keys of records.")]
Model = Annotated[str, Field(max_length=120, description="Such as dahl + spring.")]


class IdentifyRequest(BaseModel):
    """What to identify from which records; validation records are predicted.

    Without a model every model of the catalogue is tried, or those in ``tried``. The values that ``loss``, ``weighting``
    and ``predict`` allow are those of ``/api/identify/choices``.
    """

    records: Keys
    model: Model | None = None
    tried: list[Model] = Field(default=[], max_length=30)
    predict: str = Field(default="", max_length=20, description="A split to cross-validate by, or nothing.")
    loss: str = Field(default="squares", max_length=20)
    weighting: str = Field(default="records", max_length=20)
    settling: float = Field(default=SETTLING, ge=0, le=1e4, allow_inf_nan=False, description="s, not scored.")
    bandwidth: float | None = Field(default=None, gt=0, le=1e5, allow_inf_nan=False, description="Of the velocity, Hz.")
    session_prior: float = Field(
        default=PRIOR_SESSION,
        ge=0,
        lt=1,
        allow_inf_nan=False,
        description="Of the levels of sessions, where none repeats.",
    )

    def options(self) -> IdentifyOptions:
        """The options of `dampyr.identification.identify`."""
        predict = (self.predict,) if self.predict else ()
        return IdentifyOptions(
            model=self.model,
            tried=tuple(self.tried),
            predict=predict,
            loss=self.loss,
            weighting=self.weighting,
            settling=self.settling,
            bandwidth=self.bandwidth,
            session_prior=self.session_prior,
        )


class ValidateRequest(BaseModel):
    """Records that a damper predicts: a card of the data folder (``cards/NAME.toml``) or a published set."""

    records: Keys
    card: str = Field(min_length=1, max_length=200)
    settling: float = Field(default=SETTLING, ge=0, le=1e4, allow_inf_nan=False, description="s, not scored.")
    allow_extrapolation: bool = False
    band: float | None = Field(
        default=LEVEL, gt=0, lt=1, description="What each predictive band is to hold; null: none."
    )
    session_prior: float | None = Field(
        default=None,
        ge=0,
        lt=1,
        allow_inf_nan=False,
        description="Of the level between sessions; null: as the card states.",
    )

    def options(self) -> ValidateOptions:
        """The options of `dampyr.identification.validate`."""
        return ValidateOptions(self.settling, self.allow_extrapolation, self.band, self.session_prior)
