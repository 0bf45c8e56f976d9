"""What was measured: one test, one clock; readers, conditioning, cycles.

A :class:`Record` is read with :func:`read` or :func:`read_campaign`, in SI, checked and immutable. Each
conditioning step returns a new record whose history says what was done; each report (:func:`measure`,
:func:`quality`, :func:`overview`, :func:`estimate_delay`, :func:`recognise_smoothing`, :func:`displacement_noise`)
changes nothing.
"""

from dampyr.records.checks.overview import overview
from dampyr.records.checks.quality import quality
from dampyr.records.conditioning.cut_record import cut
from dampyr.records.conditioning.force_lag import correct_delay, estimate_delay
from dampyr.records.conditioning.force_offset import remove_offset
from dampyr.records.conditioning.lowpass import displacement_noise, with_lowpass
from dampyr.records.conditioning.moving_average import Declaration, MovingAverage
from dampyr.records.conditioning.nominal_input import nominal_inputs
from dampyr.records.conditioning.repair import remove_drift, repair, undo_repairs
from dampyr.records.conditioning.smoothing import with_smoothing
from dampyr.records.conditioning.smoothing_recognition import recognise_smoothing
from dampyr.records.conditioning.velocity import differentiate, with_velocity
from dampyr.records.cycle_analysis.amplitude_spectrum import spectrum
from dampyr.records.cycle_analysis.cycle_figures import CycleOptions, cycles
from dampyr.records.cycle_analysis.cycle_table import cycle_table
from dampyr.records.cycle_analysis.cycles import cut_cycles, cycle_average, cycle_bounds
from dampyr.records.cycle_analysis.measure import amplitude_error, measure, total_harmonic_distortion
from dampyr.records.datasets import fetch, locate
from dampyr.records.description import describe
from dampyr.records.files.campaign_folder import read_campaign, read_records
from dampyr.records.files.conversion import convert
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.record_files import read, write
from dampyr.records.record import Record
from dampyr.records.record_thresholds import RecordThresholds
from dampyr.records.specimen_history import specimens

__all__ = [
    "Record", "ReadOptions", "read", "write", "convert", "cut", "read_campaign", "read_records", "nominal_inputs", "fetch",
    "locate", "cycle_bounds", "cut_cycles", "cycle_average", "differentiate", "with_velocity", "remove_offset", "remove_drift",
    "estimate_delay", "correct_delay", "measure", "amplitude_error", "total_harmonic_distortion", "overview", "quality",
    "describe", "spectrum", "recognise_smoothing", "Declaration", "MovingAverage", "with_smoothing", "displacement_noise",
    "with_lowpass", "repair", "undo_repairs", "cycle_table", "cycles", "CycleOptions", "RecordThresholds",
    "specimens",
]  # fmt: skip
