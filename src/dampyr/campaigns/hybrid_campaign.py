"""Hybrid tests as campaigns: the plan of one, and what its record has shown."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.campaigns.campaign import campaign_of
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.kinds import kind
from dampyr.campaigns.planned_tests import Plan, plan
from dampyr.config import fill
from dampyr.errors import InputError
from dampyr.findings import handed_on
from dampyr.hybrid.hybrid_result import HybridResult, follow_record, modelled_force, replayed
from dampyr.hybrid.rig_drive import HybridDrive
from dampyr.hybrid.substructure import LARGEST_LAG, lag_of
from dampyr.models import published
from dampyr.records import Record, read
from dampyr.rig import RigSettings, load_settings


def planned_hybrid(settings: Mapping[str, Any], rig: str | Path | None = None) -> Plan:
    """The plan of a campaign of one hybrid test; ``settings`` as of a ``[[step]]`` of that kind, its files as seen from here.

    ``rig`` is a ``rig.toml``, None the original rig. The plan's refusals say what the rig cannot do, and what is unstable.
    """
    rig_settings = RigSettings() if rig is None else load_settings(rig)
    folder, card = None if rig is None else Path(rig).parent, rig_settings.specimen.card
    step = dict(settings)
    if not step.get("model") and card and folder and card not in published.available_sets():
        step["model"] = str((folder / card).resolve())  # a path from the rig's file, where the step's are from here
    campaign = campaign_of({"name": "hybrid", "rest_between": 0.0, "step": [step]}, Path.cwd())
    return plan(campaign, rig_settings, specimen(rig_settings, folder))


def hybrid_result(source: Record | str | Path) -> HybridResult:
    """What the record of a test of the kind ``hybrid`` has shown.

    Its building is computed anew with the force of the record. :class:`~dampyr.errors.InputError` for a record of another kind,
    and MissingData where a file that the test names has gone.
    """
    record = source if isinstance(source, Record) else read(source)
    if record.provenance.get("kind") != "hybrid":
        raise InputError(
            f"{record.name} is a test of the kind {record.provenance.get('kind', 'unknown')!r}, and not hybrid"
        )
    step = fill(kind("hybrid"), json.loads(record.provenance["step"]))
    rig_text = record.provenance.get("rig")
    settings = fill(RigSettings, json.loads(rig_text)) if rig_text else RigSettings()
    drive: HybridDrive = step.drive(settings)
    run, static = replayed(drive, record.displacement, record.force, settings)
    law, unit, asked, voltage = drive.substructure.law, "V", None, step.voltage
    if law is not None:
        asked, unit = follow_record(drive, run, np.asarray(record.voltage), settings), step.damper(settings).input
        voltage = float(asked[:-1].mean()) * drive.volts_per_input
    lag, gain = lag_of(run.target, run.achieved, drive.substructure.h, LARGEST_LAG)
    n = drive.substructure.building.n_floors
    return HybridResult(
        step.title, step.scale, step.clock, voltage, np.asarray(np.arange(run.now + 1) * drive.substructure.h, float),
        np.ascontiguousarray(run.z[:, :n].T), run.target, run.achieved, run.force,
        modelled_force(drive.substructure, run), static, lag, gain, run.energy_error,
        step.computed(settings), record.origin, handed_on([record]), drive.law, asked, unit,
    )  # fmt: skip
