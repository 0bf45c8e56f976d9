"""What was measured: one test, one clock; readers, conditioning, cycles.

A :class:`Record` is read with :func:`read` or :func:`read_campaign`, in SI, checked and immutable. Each
conditioning step returns a new record whose history says what was done; each report (:func:`measure`,
:func:`quality`, :func:`disagreements`, :func:`estimate_delay`, :func:`drift`, :func:`recognise_smoothing`,
:func:`displacement_noise`) changes nothing.
"""

from dampyr.records.amplitude_spectrum import spectrum
from dampyr.records.campaign_folder import CampaignRow, campaign_rows, read_campaign, read_row
from dampyr.records.channel_noise import quantum
from dampyr.records.comparison import write_comparison
from dampyr.records.conversion import convert
from dampyr.records.cut_record import cut
from dampyr.records.cycle_table import Cycle, cycle_table
from dampyr.records.cycles import Cut, CutCycle, Level, cut_cycles, cycle_average, cycles, legs, turning_points
from dampyr.records.datasets import fetch, locate
from dampyr.records.description import describe
from dampyr.records.drift import drift, remove_drift
from dampyr.records.force_lag import Delay, correct_delay, estimate_delay
from dampyr.records.force_offset import mean_force, remove_offset
from dampyr.records.label_checks import creates_energy, disagreements
from dampyr.records.lowpass import DisplacementNoise, displacement_noise, with_lowpass
from dampyr.records.measure import Measured, amplitude_error, cycle_energies, measure, total_harmonic_distortion
from dampyr.records.moving_average import Declaration, MovingAverage
from dampyr.records.nominal_input import nominal_inputs
from dampyr.records.overview import Overview, overview
from dampyr.records.quality import Quality, motion_start, quality
from dampyr.records.record import Label, Record
from dampyr.records.record_files import read, write
from dampyr.records.smoothing import with_smoothing
from dampyr.records.smoothing_inverse import Undone, undo
from dampyr.records.smoothing_recognition import Recognised, recognise_smoothing
from dampyr.records.velocity import check_bandwidth, default_bandwidth, differentiate, with_velocity
from dampyr.records.waveform import waveform

__all__ = [
    "Label",
    "Record",
    "read",
    "write",
    "write_comparison",
    "convert",
    "cut",
    "CampaignRow",
    "campaign_rows",
    "read_campaign",
    "read_row",
    "nominal_inputs",
    "fetch",
    "locate",
    "motion_start",
    "turning_points",
    "legs",
    "cycles",
    "Cut",
    "CutCycle",
    "Level",
    "cut_cycles",
    "cycle_average",
    "differentiate",
    "check_bandwidth",
    "default_bandwidth",
    "with_velocity",
    "mean_force",
    "remove_offset",
    "drift",
    "remove_drift",
    "Delay",
    "estimate_delay",
    "correct_delay",
    "Measured",
    "measure",
    "amplitude_error",
    "total_harmonic_distortion",
    "cycle_energies",
    "Overview",
    "overview",
    "Quality",
    "quality",
    "quantum",
    "disagreements",
    "waveform",
    "creates_energy",
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
