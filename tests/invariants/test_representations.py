"""Every public object shows itself in a few lines, in a notebook as a table, and draws and tabulates what it holds.

`EXAMPLES` has one object of each public class. A class that is new is not in it, and fails the first test.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import dampyr as dp
from dampyr import hybrid
from dampyr.campaigns.check import Violation
from dampyr.campaigns.judgement import JudgedSpecimens
from dampyr.campaigns.protocol_result import ProtocolFigure, ProtocolResult
from dampyr.campaigns.protocols.response_time import ResponseTime
from dampyr.campaigns.run_control import Progress, Skipped
from dampyr.campaigns.step import Peaks
from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import synthetic_motions
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.hybrid.substructure import LagEstimator
from dampyr.identification import FitOptions
from dampyr.identification.acceptance_tests.device_criteria import Criterion
from dampyr.identification.fits.diagnostics import Trend
from dampyr.identification.fits.residuals import Trace, motion
from dampyr.identification.limit_cycle_methods.limit_cycle import LimitCycle
from dampyr.identification.model_choice.leaderboard import Finalist
from dampyr.identification.model_choice.screening import Screened, Trial
from dampyr.identification.model_choice.yardstick import Yardstick
from dampyr.identification.parameter_uncertainty.posterior import Posterior
from dampyr.identification.parameter_uncertainty.specimens import Specimens
from dampyr.identification.scoring.validation import cross_validate
from dampyr.phrases import rounded
from dampyr.planning.planner import Planned, Round
from dampyr.records.conditioning.smoothing_inverse import undo
from dampyr.records.conditioning.smoothing_recognition import Recognised
from dampyr.records.files.campaign_folder import campaign_rows
from dampyr.records.record import Label
from dampyr.records.specimen_history import SpecimenHistories
from dampyr.rig.calibration import calibration_of
from dampyr.show.descriptions import description_of
from dampyr.show.figures import laws as law_figures
from dampyr.show.figures import style
from dampyr.show.figures.fragility import Fragile
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.notebook import rows_as_html
from dampyr.show.plots import Plots
from dampyr.show.table import Table
from dampyr.show.text import MAX_LETTERS, MAX_LINES, rows_as_text
from dampyr.shown import Shown
from dampyr.studies._study_run import StudyRun
from dampyr.studies.raminelli_2020.study import Study
from dampyr.studies.raminelli_2020.study_part import StudyPart
from dampyr.studies.vrths_2020.vrths_study import VrthsStudy
from tests.campaigns.specimen_folders import QUASI_STATIC, dahl, specimen_folder
from tests.identification.synthetic import sine
from tests.records.specimen_record import specimen_record

LINES, LETTERS = 15, 1500
MOTIONS = ((0.005, 1.0), (0.010, 0.5), (0.008, 0.8))  # m, Hz
VOLTS = (0.0, 1.0, 2.0)
STEPS = [{"kind": "sine", "amplitude": ["5 mm", "8 mm"], "frequency": "1 Hz", "voltage": "0.8712 V", "cycles": 2}]


def late_by_10_ms(made: Any) -> HybridResult:
    """A hybrid test on an actuator that is 10 ms late."""
    return delayed_result(dp.structures.two_storey(), made.shake, dp.studies.raminelli_2020.damper(), 0.010)


def posterior_of(fit: dp.identification.Fit) -> Posterior:
    """Samples of a fit, as few as show themselves."""
    pytest.importorskip("emcee", reason="the extra bayes is not installed: pip install dampyr[bayes]")
    return dp.identification.sample_posterior(fit, lengths=5.0, steps=250)


def three_specimens(made: Any) -> Specimens:
    """Three dampers that were tested alike."""
    groups = {
        f"damper {n}": [
            sine(made.damper, 1.0, f"{n}-{k}", a, f, noise=8.0, seed=10 * n + k) for k, (a, f) in enumerate(MOTIONS)
        ]
        for n in range(3)
    }
    return dp.identification.fit_specimens(groups, "dahl")


def substructure(made: Any) -> hybrid.Substructure:
    """The computed part of a hybrid test."""
    return hybrid.Substructure(dp.structures.two_storey(), 1, made.shake.acceleration, made.shake.dt)


def judged_specimen() -> JudgedSpecimens:
    """A specimen that holds its criteria."""
    folder = specimen_folder(Path(tempfile.mkdtemp()), QUASI_STATIC, dahl(300.0, 4000.0))
    return dp.campaigns.judge(folder, [Criterion("energy", "all", "cycle 3", "a test", -0.1, 0.1)])


def specimens_of_a_folder() -> SpecimenHistories:
    """The history of one specimen, tested twice."""
    folder = Path(tempfile.mkdtemp())
    for day in ("2026-01-01", "2026-03-01"):
        dp.records.write(specimen_record("SN1", day, day), folder / f"{day}.h5")
    return dp.records.specimens(folder)


def public_classes() -> list[type]:
    """Every class that some ``__all__`` names, and every result that a call returns; protocols have no objects of their own."""
    classes = set()
    for package_module in pkgutil.walk_packages(dp.__path__, "dampyr."):
        if package_module.name.endswith("__main__"):
            continue
        module = importlib.import_module(package_module.name)
        faces = [getattr(module, name) for name in getattr(module, "__all__", ())]
        results = [value for name, value in vars(module).items() if name[0] != "_" and shows_itself(value)]
        classes |= {
            value
            for value in [*faces, *results]
            if inspect.isclass(value) and not getattr(value, "_is_protocol", False)
        }
    return sorted(classes, key=label)


def shows_itself(value: Any) -> bool:
    """Whether a class has a description; one that derives from such a class has that one's."""
    return inspect.isclass(value) and issubclass(value, Shown) and Shown in value.__bases__


def label(cls: type) -> str:
    """Such as ``identification.Fit``."""
    return f"{cls.__module__.split('.')[1]}.{cls.__name__}"


EXAMPLES: dict[str, Callable[[SimpleNamespace], Any]] = {
    "hybrid.BatchResult": lambda made: hybrid.run_many(made.hybrid, made.compensator, made.shake, 2),
    "hybrid.Criteria": lambda made: hybrid.perform_virtual(made.hybrid, made.compensator, made.shake).criteria(),
    "hybrid.HybridSetup": lambda made: made.hybrid,
    "hybrid.HybridResult": lambda made: late_by_10_ms(made),
    "hybrid.LagEstimator": lambda made: LagEstimator(0.001, 0.01, lag=0.005),
    "hybrid.Substructure": lambda made: substructure(made),
    "hybrid.SubstructureRun": lambda made: substructure(made).run(),
    "hybrid.KalmanCompensator": lambda made: made.compensator,
    "hybrid.LoopStability": lambda made: hybrid.loop_stability(made.hybrid, made.compensator),
    "hybrid.ModelBasedCompensator": lambda made: hybrid.ModelBasedCompensator(),
    "hybrid.PhaseLeadCompensator": lambda made: hybrid.PhaseLeadCompensator(),
    "hybrid.Sensors": lambda made: hybrid.Sensors(),
    "hybrid.PhysicalSubstructure": lambda made: hybrid.PhysicalSubstructure(),
    "hybrid.TransferSystem": lambda made: hybrid.TransferSystem(),
    "hybrid.PlantSpread": lambda made: hybrid.PlantSpread(),
    "hybrid.VirtualRun": lambda made: hybrid.perform_virtual(made.hybrid, made.compensator, made.shake),
    "campaigns.Campaign": lambda made: made.campaign,
    "campaigns.CampaignThresholds": lambda made: dp.campaigns.CampaignThresholds(),
    "campaigns.RunControl": lambda made: dp.campaigns.RunControl(),
    "campaigns.Violation": lambda made: Violation("voltage", "needs 9 V; the limit is 4.4 V"),
    "campaigns.Header": lambda made: made.campaign.header,
    "campaigns.Journal": lambda made: made.journal,
    "planning.Peak": lambda made: dp.planning.Peak(made.building, made.motion, 1.98),
    "planning.PlanOptions": lambda made: dp.planning.PlanOptions(tests=2),
    "planning.Planned": lambda made: Planned(
        Path("lab"), (made.round,), made.fit, False, "all 2 tests are performed", "all parameters"
    ),
    "planning.Proposal": lambda made: made.proposal,
    "planning.ProposedTest": lambda made: made.proposal.tests[0],
    "planning.Round": lambda made: made.round,
    "campaigns.Peaks": lambda made: Peaks(0.010, 0.063),
    "campaigns.Plan": lambda made: made.plan,
    "campaigns.PlannedTest": lambda made: made.plan.tests[0],
    "campaigns.ProtocolResult": lambda made: ProtocolResult(
        "response_time",
        ResponseTime(0.012, (0.03,), (1.98,)),
        (),
        (ProtocolFigure("01-voltage_switch", "t63", 0.012),),
        (),
    ),
    "campaigns.Progress": lambda made: Progress(1, 2, "01-sine", "recording", 0.5, 4.0),
    "campaigns.Skipped": lambda made: Skipped("skipped by the operator"),
    "campaigns.Stopped": lambda made: dp.campaigns.Stopped("the campaign was stopped by its operator"),
    "campaigns.JudgedSpecimens": lambda made: judged_specimen(),
    "records.SpecimenHistories": lambda made: specimens_of_a_folder(),
    "campaigns.RecordedCampaign": lambda made: recorded(made.records),
    "campaigns.Test": lambda made: made.campaign.tests[0],
    "show.Fragile": lambda made: Fragile(np.linspace(0.1, 3.0, 300), np.linspace(0.0, 1.0, 300)),
    "show.LawPanel": lambda made: law_figures.LawPanel(
        style.Axis("kx", "N s/mm", 1e-3), curve=(np.linspace(0, 2, 200), np.linspace(800, 2600, 200))
    ),
    "ground_motions.MotionReadOptions": lambda made: dp.ground_motions.MotionReadOptions(columns={"acceleration": "a"}),
    "ground_motions.GroundMotion": lambda made: made.motion,
    "ground_motions.Measures": lambda made: dp.ground_motions.measures(made.motion),
    "ground_motions.RisePlateauDecay": lambda made: dp.ground_motions.RisePlateauDecay(0.1, 0.5, 0.05),
    "ground_motions.ShinozukaSato": lambda made: dp.ground_motions.ShinozukaSato(0.2, 0.6),
    "ground_motions.Soil": lambda made: dp.ground_motions.MEDIUM,
    "ground_motions.MotionEntry": lambda made: dp.ground_motions.read_folder(made.motion_file).entries[0],
    "ground_motions.MotionTable": lambda made: dp.ground_motions.read_folder(made.motion_file),
    "ground_motions.DesignSpectrum": lambda made: dp.ground_motions.asce_7(sds=10.0, sd1=6.0, tl=8.0),
    "ground_motions.DesignComparison": lambda made: dp.ground_motions.compare_with_design(
        made.motion, dp.ground_motions.eurocode_8(2.5, "C"), (0.0, 0.2, 0.5, 1.0)
    ),
    "ground_motions.InelasticSpectrum": lambda made: dp.ground_motions.inelastic_spectrum(made.motion, 2.0, [0.5, 1.0]),
    "ground_motions.MatchedMotion": lambda made: dp.ground_motions.matched_to_design(
        made.motion, dp.ground_motions.eurocode_8(2.5, "C"), 0.4, 1.0
    ),
    "ground_motions.TableSpectrum": lambda made: dp.ground_motions.TableSpectrum("site", [0.1, 1.0], [5.0, 2.0]),
    "ground_motions.RotatedSpectrum": lambda made: dp.ground_motions.rotated_spectrum(
        made.motion, made.motion, [0.2, 0.5]
    ),
    "ground_motions.Spectrum": lambda made: dp.ground_motions.spectrum(made.motion, damping=(0.02, 0.05)),
    "identification.AcceptOptions": lambda made: dp.identification.AcceptOptions(),
    "identification.Acceptance": lambda made: made.accepted.results[0],
    "identification.Accepted": lambda made: made.accepted,
    "identification.Band": lambda made: made.band,
    "identification.Interval": lambda made: made.band.peak,
    "identification.Levels": lambda made: made.fit.levels,
    "identification.Finalist": lambda made: made.board.entries[0],
    "identification.Inseparable": lambda made: dp.identification.identifiability(made.fit).inseparable[0],
    "identification.Fit": lambda made: made.fit,
    "identification.Fold": lambda made: made.validation.folds[0],
    "identification.Identifiability": lambda made: dp.identification.identifiability(made.fit),
    "identification.FitThresholds": lambda made: dp.identification.FitThresholds(),
    "identification.FitOptions": lambda made: dp.identification.FitOptions(),
    "identification.Leaderboard": lambda made: made.board,
    "identification.LimitCycle": lambda made: LimitCycle(
        800.0, 2.1e6, 42e3, 50.2, -0.009, -0.004, (41e3, 43e3), np.linspace(-0.01, 0.01, 500), np.linspace(-50, 50, 500)
    ),
    "identification.MethodComparison": lambda made: dp.identification.compare_method(
        made.records[:2], "plastic-region"
    ),
    "identification.MethodResult": lambda made: dp.identification.compare_method(
        made.records[0], "plastic-region"
    ).results[0],
    "identification.Nuisance": lambda made: next(iter(made.fit.nuisances.values())),
    "identification.Posterior": lambda made: posterior_of(dp.identification.fit(made.records[:3], "dahl")),
    "identification.Profile": lambda made: dp.identification.profile(made.fit, "dahl.rho @ 1 V", points=7),
    "identification.PlasticRegion": lambda made: dp.identification.plastic_region(made.records[-1]),
    "identification.AcceptancePoint": lambda made: made.accepted.results[0].points[0],
    "identification.Residuals": lambda made: made.fit.residuals,
    "identification.Score": lambda made: made.fit.scores[made.records[0].name],
    "identification.Screened": lambda made: made.board.screened[0],
    "identification.Specimens": lambda made: three_specimens(made),
    "identification.SpecimenSpread": lambda made: three_specimens(made).spreads["dahl.kw"],
    "identification.Tolerance": lambda made: dp.identification.Tolerance(),
    "identification.Trace": lambda made: trace_of(made.records[0]),
    "identification.Trend": lambda made: Trend("stroke", 1.0, 0.7, 0.01, 8, 0.2, True),
    "identification.Trial": lambda made: made.board.screened[0].trials[0],
    "identification.ScoreOptions": lambda made: dp.identification.ScoreOptions(),
    "identification.Validated": lambda made: made.validated,
    "identification.Validation": lambda made: made.validation,
    "identification.Window": lambda made: made.fit.scores[made.records[0].name].window,
    "identification.Yardstick": lambda made: Yardstick("a network of two layers", 0.05, 0.04, 0.08, 3217, 41.0),
    "models.Composition": lambda made: made.damper.composition,
    "models.Constant": lambda made: dp.models.Constant(3.0),
    "models.Damper": lambda made: made.fit.damper,
    "models.Interpolation": lambda made: made.fit.damper.all_laws["dahl.kx"],
    "models.WithTemperature": lambda made: dp.models.WithTemperature(
        dp.models.Constant(3.0), dp.models.Constant(2.0), (15.0, 45.0)
    ),
    "models.Polynomial": lambda made: made.damper.all_laws["dahl.kx"],
    "records.DataFile": lambda made: dp.records.datasets.data_set("el_centro_peknold").files[0],
    "records.DataSet": lambda made: dp.records.datasets.data_set("labcontrol"),
    "records.CampaignRow": lambda made: campaign_rows()[0],
    "records.Cut": lambda made: dp.records.cut_cycles(made.records[0]),
    "records.CutCycle": lambda made: dp.records.cut_cycles(made.records[0]).cycles[0],
    "records.Cycle": lambda made: dp.records.cycle_table(made.records[0])[0],
    "records.CycleFigures": lambda made: dp.records.cycles(made.records),
    "records.RecordFigures": lambda made: dp.records.cycles(made.records[0])[0],
    "records.Declaration": lambda made: dp.records.Declaration.of("0.1 periods, trailing"),
    "records.ForceLag": lambda made: dp.records.estimate_delay(made.records[0]),
    "records.DisplacementNoise": lambda made: dp.records.displacement_noise(made.records[0]),
    "records.Label": lambda made: Label(0.02, 1.0, "4.2", 1),
    "records.Level": lambda made: dp.records.cut_cycles(made.records[0]).levels[0],
    "records.Measured": lambda made: dp.records.measure(made.records[0]),
    "records.MovingAverage": lambda made: dp.records.MovingAverage(0.3),
    "records.Overview": lambda made: dp.records.overview(made.records[0]),
    "records.RecordThresholds": lambda made: dp.records.RecordThresholds(),
    "records.CycleOptions": lambda _: dp.records.CycleOptions(),
    "records.ReadOptions": lambda made: dp.records.ReadOptions(voltage=1.98, smoothed="0.1 periods"),
    "records.Quality": lambda made: dp.records.quality(made.records[0]),
    "records.Recognised": lambda made: Recognised("force", 50, 0.1, 0.1, 15.2, 14.0),
    "records.Record": lambda made: made.records[0],
    "records.Undone": lambda made: undo(made.records[0].force, 4, 4),
    "show.FigureBlock": lambda made: dp.show.FigureBlock(
        ground_motion(made.motion.time, made.motion.acceleration), "The ground."
    ),
    "show.Section": lambda made: dp.show.Section("Numbers", [made.page_table, dp.show.Text("None.")]),
    "show.Table": lambda made: made.page_table,
    "show.Text": lambda made: dp.show.Text("\n\n".join(f"Paragraph {k}. " + "word " * 200 for k in range(9))),
    "show.Verdict": lambda made: dp.show.Verdict("agrees"),
    "rig.Calibration": lambda made: calibration_of(made.rig.settings),
    "rig.Drive": lambda made: made.plan.tests[0].drive,
    "rig.DutyReversals": lambda made: dp.rig.DutyReversals(0.8, 1.0),
    "rig.Rig": lambda made: made.rig,
    "rig.RigSettings": lambda made: made.rig.settings,
    "rig.ArmedRig": lambda made: made.table,
    "structures.Arena": lambda made: dp.structures.arena(made.ensemble),
    "structures.ControlSearch": lambda made: dp.structures.search_control(
        made.building, [made.motion] * 4, made.damper, [0.0, 1.0, 2.0]
    ),
    "structures.Building": lambda made: dp.structures.shear_building([1e5] * 40, [1e8] * 40, damping_ratio=0.05),
    "structures.Condensed": lambda made: made.condensed,
    "structures.FragilityCurve": lambda made: made.ensemble.curves[0].curves[0],
    "structures.Energy": lambda made: made.response.energy,
    "structures.ControlLaw": lambda _: dp.structures.ControlLaw(0.0, 1.0),
    "structures.LawDesign": lambda _: dp.structures.LawDesign({"sum": np.ones(3)}),
    "structures.Sensor": lambda _: dp.structures.Sensor(noise=0.1),
    "structures.EnsembleOptions": lambda made: dp.structures.EnsembleOptions(limits="12mm"),
    "structures.EnsembleResult": lambda made: made.ensemble,
    "structures.Fragility": lambda made: made.ensemble.curves[0],
    "structures.Incremental": lambda made: made.incremental,
    "structures.Response": lambda made: made.response,
    "structures.RideFigures": lambda _: dp.structures.RideFigures(
        0.9, 1.2, 4.1, 1.4, 2.3, 0.006, 0.021, 420.0, 1400.0, 3530.4, 0.0
    ),
    "structures.FloorLoads": lambda _: dp.structures.FloorLoads([0.0, 0.5, 1.0], {1: [0.0, 30.0, 0.0]}, "gust"),
    "structures.SupportMotions": lambda _: dp.structures.axle_roads(0.01 * np.hanning(41), 0.1, 10.0, 2.6),
    "structures.Rides": lambda made: dp.structures.rides(
        dp.structures.quarter_car(290.0, 45.0, 18e3, 190e3, 300.0), made.damper, 1.98, seeds=2, length=50.0
    ),
    "structures.RespondOptions": lambda made: dp.structures.RespondOptions(after=2.0),
    "structures.Responses": lambda made: made.responses,
    "structures.StateSpace": lambda made: dp.structures.state_space(made.building),
    "structures.IncrementalCurves": lambda made: made.incremental.sweeps[0],
    "studies.ComparedValue": lambda made: made.study.compared[0],
    "studies.Published": lambda made: dp.studies.raminelli_2020.PUBLISHED,
    "studies.Study": lambda made: made.study,
    "studies.StudyRun": lambda made: StudyRun(
        "a_2020", "A (2020)", "a paper", tuple(made.study.compared[:3]), ("the rest",)
    ),
    "studies.VrthsStudy": lambda made: VrthsStudy(
        (), {("El Centro", "kalman", 1): (np.ones(9), np.ones(9))}, {}, (np.zeros(1), {})
    ),
}
NEEDS_A_RECORD = {
    ("identification.Validated", "history"),
    ("identification.Validated", "loops"),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """What the examples are made of: a few simulated records, a building, and a rig in this process."""
    made = SimpleNamespace()
    made.motion_file = tmp_path_factory.mktemp("motions") / "pulse.csv"
    made.motion_file.write_text("time [s],acceleration [g]\n0,0.1\n0.01,-0.2\n0.02,0.1\n")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        _identify(made)
        _build(made)
    made.page_table = dp.show.Table(("x", "y"), [[k, 0.5 * k] for k in range(1000)], ("mm", "N"))
    made.campaign = dp.campaigns.campaign_of({"name": "a notebook", "operator": "me", "step": STEPS})
    made.plan = dp.campaigns.plan(made.campaign)
    made.proposal = dp.planning.propose(made.damper, tests=2, seconds=4.0, voltages=(0.0, 1.98), kinds=("sine",))
    halves = {"dahl.kx @ 0 V": 0.02, "dahl.rho @ 0 V": 0.1}
    made.round = Round(1, Path("lab/round-01"), ("01-sine",), 20.0, halves, halves)
    made.journal = dp.campaigns.Journal(tmp_path_factory.mktemp("journal"))
    made.journal.plan("1234", [test.name for test in made.campaign.tests], {"name": "a notebook"})
    finding = dp.studies.raminelli_2020.ComparedValue("table 4.1", "kx", 0.802, 0.8017, "N s/mm", "agrees", "")
    made.study = Study((StudyPart("a title", [finding], []),), None, ())
    with dp.rig.simulated() as made.rig, made.rig.armed() as made.table:
        yield made
    made.journal.close()


def _identify(made: SimpleNamespace) -> None:
    made.damper = dp.studies.raminelli_2020.damper()
    made.records = [
        sine(made.damper, u, f"{1e3 * a:g} mm at {u:g} V", a, f, noise=8.0, seed=k)
        for k, (u, a, f) in enumerate((u, a, f) for u in VOLTS for a, f in MOTIONS)
    ]
    made.fit = dp.identification.fit(made.records, "dahl")
    made.band = dp.identification.prediction_band(made.fit.damper, made.records[0], draws=20)
    made.validation = cross_validate(made.records, "dahl", options=FitOptions(folds=3))
    made.accepted = dp.identification.accept(made.records, made.damper)
    made.validated = dp.identification.validate(made.damper, made.records)
    entry = Finalist(
        "dahl", 0.09, 0.004, 0.09, 0.1, 0.12, 0.01, 0.1, 9, 1.0, True, "converged", (made.validation,), made.fit
    )
    trials = tuple(Trial(name, 0.1, 1.0) for name in ("dahl", "dahl + spring"))
    screened = tuple(Screened(name, trials) for name in ("dahl", "bingham"))
    made.board = dp.identification.Leaderboard((entry, entry), screened, 15.0, ("lag was not tried",), 60.0)


def _build(made: SimpleNamespace) -> None:
    S = dp.structures
    made.motion, made.building = dp.ground_motions.el_centro(), S.two_storey()
    made.responses = S.respond(made.building, made.motion, made.damper, voltage=[0.0, 1.98])
    made.condensed = made.building.condensed([2])
    made.response = made.responses.cases["1.98 V"]
    made.ensemble = S.ensemble(
        made.building, synthetic_motions(4, duration=8.0), [None, made.damper], [0.0, 1.98], (0.5, 1.0), limits="15mm"
    )
    made.incremental = S.incremental(made.ensemble.dataset)
    made.hybrid = hybrid.HybridSetup(dp.studies.vrths_2020.structure(1))
    made.compensator, made.shake = hybrid.KalmanCompensator.designed(made.hybrid), synthetic_motions(1, duration=4.0)[0]


def recorded(records: list[dp.records.Record]) -> Any:
    """As the campaign of these records in a folder."""
    campaign = dp.campaigns.RecordedCampaign(Path("lab"))
    campaign.__dict__["records"] = tuple(records)
    return campaign


def trace_of(record: dp.records.Record) -> Any:
    """The residual of a model that says 0 N."""
    return Trace(
        record.name, record.time, record.displacement, record.velocity, record.force, record.force, 0.0, *motion(record)
    )


def test_every_public_class_has_an_example() -> None:
    assert sorted(set(map(label, public_classes())) - set(EXAMPLES)) == []


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_it_shows_itself(name: str, made: SimpleNamespace, agg: Any) -> None:
    example = EXAMPLES[name](made)
    assert label(type(example)) == name
    its_text_is_a_few_lines_without_addresses(example)
    if hasattr(example, "_repr_html_"):
        its_html_stands_alone(example._repr_html_())
    its_plots_are_axes_with_units_and_something_on_them(example, agg)
    if hasattr(example, "to_dataframe"):
        its_table_is_a_data_frame(example)


@pytest.mark.prove
@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_its_figures_are_laid_out_without_a_complaint(name: str, made: SimpleNamespace, agg: Any) -> None:
    its_plots_are_axes_with_units_and_something_on_them(EXAMPLES[name](made), agg, laid_out=True)


def its_text_is_a_few_lines_without_addresses(example: Any) -> None:
    text = repr(example)
    assert len(text.splitlines()) <= LINES, text
    assert len(text) <= LETTERS, text
    assert not re.search(r"0x[0-9a-f]+|array\(|\bobject at\b|PosixPath|lambda", text), text
    assert text.startswith(f"<{type(example).__name__}") or not isinstance(example, Shown), text


def its_html_stands_alone(html: str) -> None:
    ElementTree.fromstring(html)
    assert not re.search(r"<script|<link|<img|\bsrc=|href=\"(?!#)|url\((?!#)", html)
    assert "array(" not in html


def test_the_same_object_gives_the_same_html(made: SimpleNamespace) -> None:
    assert made.fit._repr_html_() == made.fit._repr_html_()


def drawings(example: Any) -> list[tuple[str, Callable[..., Any]]]:
    """The calls that draw it, by name."""
    plot = getattr(example, "plot", None)
    if plot is None or isinstance(example, dp.campaigns.Journal):
        return []
    assert isinstance(plot, Plots)
    names = [name for name, _ in inspect.getmembers(type(plot), inspect.isfunction) if not name.startswith("_")]
    drawing = [name for name in names if inspect.signature(getattr(plot, name)).return_annotation == "Any"]
    return [("plot", plot), *((name, getattr(plot, name)) for name in drawing)]


@pytest.fixture
def agg() -> Iterator[Any]:
    """Matplotlib without a screen; every figure closed afterwards."""
    import matplotlib as mpl
    from matplotlib import pyplot

    before = mpl.get_backend()
    pyplot.switch_backend("agg")
    yield pyplot
    pyplot.close("all")
    pyplot.switch_backend(before)


def its_plots_are_axes_with_units_and_something_on_them(example: Any, agg: Any, laid_out: bool = False) -> None:
    from matplotlib.axes import Axes

    for name, draw in drawings(example):
        needs = (label(type(example)), name) in NEEDS_A_RECORD
        axes = draw(next(iter(example.scores))) if needs else draw()
        assert len(axes) >= 1, name
        assert all(isinstance(each, Axes) for each in axes), name
        shown = [each for each in axes if each.axison]
        assert all(each.lines or each.collections or each.patches for each in shown), name
        words = {each.get_xlabel() for each in shown} | {each.get_ylabel() for each in shown}
        assert len(words - {""}) >= 1, name
        assert all(re.search(r"\[.+\]$", text) for text in words - {"", "floor"}), (name, words)
        figure = axes[0].figure
        if not laid_out:
            figure.set_layout_engine("none")  # where panels come to lie takes most of the time
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
        assert np.mean(np.any(pixels < 250, axis=-1)) > 0.005, f"{name} is blank"
        agg.close(figure)


def its_table_is_a_data_frame(example: Any) -> None:
    import pandas as pd

    if isinstance(example, Shown) and "to_dataframe" not in vars(type(example)):
        description = description_of(example)
        if not description.tables and description.frame is None:
            with pytest.raises(InputError, match=f"{type(example).__name__} is not a table"):
                example.to_dataframe()
            return
    frame = example.to_dataframe()
    assert isinstance(frame, pd.DataFrame)
    assert len(frame) >= 1
    assert all(isinstance(name, str) and name for name in frame.columns)


def test_a_table_without_pandas_says_what_to_install(made: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(InputError, match="needs pandas, which is not installed; install it with: python -m pip"):
        made.records[0].to_dataframe()


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda m: m.fit.plot.loops(m.records[0].replace(note="renamed", name="no such")),
            "'no such' is not among the fitted records",
        ),
        (lambda m: m.fit.plot.loops("no such"), "'no such' is not among the fitted records; choose from 5 mm at 0 V"),
        (lambda m: m.validated.plot.history("no such"), "'no such' is not among the records; choose from"),
        (lambda m: m.damper.plot.loops(amplitude=-1.0), "amplitude = -1 m is not allowed; it must be greater than 0"),
        (lambda m: m.ensemble.plot.fragility(7), "number = 7 is not allowed; there are 1 limits"),
        (lambda m: m.ensemble.curves[0].plot(["no such"]), "there is no curve 'no such'; choose from no damper"),
        (lambda m: m.ensemble.curves[0].plot([]), "names has 0 curves; a figure shows 1 to 6"),
        (lambda m: m.responses.plot.history("9"), "'9' is not a floor of .*; choose from 1, 2"),
        (
            lambda m: dp.ground_motions.spectrum(m.motion).plot("force"),
            "'force' is not a quantity of a spectrum; choose from displacement",
        ),
        (lambda m: dp.ground_motions.spectrum(m.motion, 1.0).plot(), "a figure needs two periods or more"),
        (lambda m: m.records[0].plot.history("current"), "has no channel 'current' to draw; choose from displacement"),
        (lambda m: m.response.plot.history("no such"), "this response has no history of 'no such'; choose from"),
    ],
)
def test_a_wrong_name_says_which_there_are(
    made: SimpleNamespace, agg: Any, call: Callable[[SimpleNamespace], Any], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        call(made)


def test_long_texts_are_cut_and_html_is_escaped() -> None:
    rows: Sequence[tuple[str, str]] = [(f"row {k}", "word " * 100) for k in range(40)]
    lines = rows_as_text("A <title>", rows).splitlines()
    assert len(lines) == MAX_LINES + 1
    assert lines[-1].endswith("and 28 more")
    assert max(map(len, lines)) <= MAX_LETTERS + len("  row 39  ")
    html = rows_as_html("A <title>", [("<b>", "1 < 2 & 3")], Table(("a", "b"), [["x", 1.5]] * 40))
    ElementTree.fromstring(html)
    assert "A &lt;title&gt;" in html
    assert "1 &lt; 2 &amp; 3" in html
    assert "and 16 more rows" in html


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(110.4, 2, "110"), (12345.6, 4, "12350"), (0.012345, 2, "0.012"), (-645.23, 4, "-645.2"), (1.5e-7, 2, "1.5e-07"),
     (2.34e8, 2, "2.3e+08"), (0.0, 2, "0"), (float("nan"), 2, "nan")],
)  # fmt: skip
def test_numbers_for_people_have_no_exponent_where_none_is_needed(value: float, digits: int, text: str) -> None:
    assert rounded(value, digits) == text
