"""Ground motions: El Centro 1940 built in, others read from files (PEER, networks, columns, MATLAB), or made by seed.

``el_centro()``, ``read(path, units=..., dt=..., component=...)``, ``read_folder(folder)``, ``GroundMotion(acceleration, dt)``
and ``kanai_tajimi(30.0, 0.01, seed=1, pga=3.0)``. A format is one file in ``formats/``.

Each of ``motion.scaled(1.5)``, ``motion.scaled_to_pga(3.0)``, ``motion.scaled_to_sa(4.0, 0.5)``, ``corrected``, ``filtered``,
``resampled``, ``trimmed`` and ``padded`` gives a new motion, whose ``history`` says what was done. How strong it is:
``spectrum``, ``inelastic_spectrum``, ``measures``, and of two horizontal components ``rotated_spectrum``. ``scaled_to_design``
and ``matched_to_design`` bring it to the spectrum of a code.
"""

from dampyr.ground_motions.baseline import corrected
from dampyr.ground_motions.builtin import el_centro
from dampyr.ground_motions.constant_ductility import inelastic_spectrum
from dampyr.ground_motions.cutting import followed_by_rest, padded, trimmed
from dampyr.ground_motions.design_spectra import (
    DesignSpectrum,
    TableSpectrum,
    asce_7,
    compare_with_design,
    eurocode_8,
    read_table_spectrum,
    scaled_to_design,
)
from dampyr.ground_motions.envelopes import RisePlateauDecay, ShinozukaSato, stationary
from dampyr.ground_motions.filters import filtered
from dampyr.ground_motions.intensity_measures import measures, pgd, pgv, sa
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_files import available_formats, read, read_components
from dampyr.ground_motions.motion_folder import read_folder
from dampyr.ground_motions.motion_options import MotionReadOptions
from dampyr.ground_motions.resampling import resampled
from dampyr.ground_motions.response_spectrum import spectrum
from dampyr.ground_motions.rotated_components import rotated_spectrum
from dampyr.ground_motions.soils import FIRM, MEDIUM, SOFT, Soil
from dampyr.ground_motions.spectrum_matching import matched_to_design
from dampyr.ground_motions.synthetic import kanai_tajimi, synthetic_motions

__all__ = [
    "GroundMotion", "MotionReadOptions",
    "el_centro", "read", "read_components", "read_folder", "available_formats", "spectrum", "rotated_spectrum",
    "inelastic_spectrum",
    "measures", "pgv", "pgd", "sa", "corrected",
    "filtered", "resampled",
    "trimmed", "padded", "followed_by_rest", "kanai_tajimi", "synthetic_motions", "Soil", "FIRM", "MEDIUM", "SOFT",
    "DesignSpectrum", "asce_7", "eurocode_8", "compare_with_design", "scaled_to_design", "matched_to_design",
    "TableSpectrum", "read_table_spectrum",
    "RisePlateauDecay", "ShinozukaSato", "stationary",
]  # fmt: skip
