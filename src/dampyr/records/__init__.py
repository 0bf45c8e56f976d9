"""What was measured: one test, one clock; readers, conditioning, cycles.

A :class:`Record` is read with :func:`read` or :func:`read_campaign`, in SI, checked and immutable. Each
conditioning step returns a new record whose history says what was done; each report (:func:`measure`,
:func:`quality`, :func:`disagreements`, :func:`estimate_delay`, :func:`drift`, :func:`recognise_smoothing`,
:func:`displacement_noise`) changes nothing.
"""

from dampyr.records.checks.label_checks import disagreements
from dampyr.records.checks.overview import Overview, overview
from dampyr.records.checks.quality import Quality, motion_start, quality
from dampyr.records.conditioning.cut_record import cut
from dampyr.records.conditioning.drift import drift, remove_drift
from dampyr.records.conditioning.force_lag import ForceLag, correct_delay, estimate_delay
from dampyr.records.conditioning.force_offset import mean_force, remove_offset
from dampyr.records.conditioning.lowpass import DisplacementNoise, displacement_noise, with_lowpass
from dampyr.records.conditioning.moving_average import Declaration, MovingAverage
from dampyr.records.conditioning.nominal_input import nominal_inputs
from dampyr.records.conditioning.smoothing import with_smoothing
from dampyr.records.conditioning.smoothing_inverse import Undone, undo
from dampyr.records.conditioning.smoothing_recognition import Recognised, recognise_smoothing
from dampyr.records.conditioning.velocity import differentiate, with_velocity
from dampyr.records.cycle_analysis.amplitude_spectrum import spectrum
from dampyr.records.cycle_analysis.cycle_table import Cycle, cycle_table
from dampyr.records.cycle_analysis.cycles import Cut, CutCycle, Level, cut_cycles, cycle_average, cycles, turning_points
from dampyr.records.cycle_analysis.measure import Measured, amplitude_error, measure, total_harmonic_distortion
from dampyr.records.cycle_analysis.waveform import waveform
from dampyr.records.datasets import fetch, locate
from dampyr.records.description import describe
from dampyr.records.files.campaign_folder import CampaignRow, campaign_rows, read_campaign
from dampyr.records.files.comparison import write_comparison
from dampyr.records.files.conversion import convert
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.record_files import read, write
from dampyr.records.record import Label, Record

__all__ = [
    "Label",
    "Record",
    "ReadOptions",
    "read",
    "write",
    "write_comparison",
    "convert",
    "cut",
    "CampaignRow",
    "campaign_rows",
    "read_campaign",
    "nominal_inputs",
    "fetch",
    "locate",
    "motion_start",
    "turning_points",
    "cycles",
    "Cut",
    "CutCycle",
    "Level",
    "cut_cycles",
    "cycle_average",
    "differentiate",
    "with_velocity",
    "mean_force",
    "remove_offset",
    "drift",
    "remove_drift",
    "ForceLag",
    "estimate_delay",
    "correct_delay",
    "Measured",
    "measure",
    "amplitude_error",
    "total_harmonic_distortion",
    "Overview",
    "overview",
    "Quality",
    "quality",
    "disagreements",
    "waveform",
    "describe",
    "spectrum",
    "Recognised",
    "recognise_smoothing",
    "Declaration",
    "MovingAverage",
    "with_smoothing",
    "Undone",
    "undo",
    "DisplacementNoise",
    "displacement_noise",
    "with_lowpass",
    "Cycle",
    "cycle_table",
]
