"""The page of a ground motion: its intensity measures, histories, response spectra and processing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dampyr.ground_motions import (
    DesignSpectrum,
    GroundMotion,
    TableSpectrum,
    compare_with_design,
    inelastic_spectrum,
    measures,
    spectrum,
)
from dampyr.ground_motions.constant_ductility import InelasticSpectrum
from dampyr.ground_motions.response_spectrum import STANDARD_PERIODS
from dampyr.ground_motions.spectrum_matching import MatchedMotion
from dampyr.phrases import sentence
from dampyr.show.figures.ground_histories import ground_histories
from dampyr.show.figures.response_spectrum import SPECTRAL_DISPLACEMENT, response_spectrum
from dampyr.show.ground_motions.constant_ductility import inelastic_figure, inelastic_table
from dampyr.show.ground_motions.design_spectra import design_figure, design_table
from dampyr.show.ground_motions.intensity_measures import measures_table
from dampyr.show.ground_motions.motion import drift_in_words, samples_in_words
from dampyr.show.ground_motions.response_spectrum import spectrum_table
from dampyr.show.ground_motions.spectrum_matching import matched_figure, matched_table
from dampyr.show.pages.blocks import FigureBlock, Section, Text
from dampyr.show.pages.html_page import page

DAMPINGS = (0.02, 0.05, 0.1)  # ratios: the usual 5 %, one below and one above
TABLE = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)  # s, about evenly spaced in the logarithm

DRAWN = np.geomspace(0.1, 4.0, 49)  # s, of strengths: each of them is a search


def html(
    motion: GroundMotion,
    dampings: Sequence[float] = DAMPINGS,
    periods: Sequence[float] = TABLE,
    design: DesignSpectrum | TableSpectrum | None = None,
    matched: MatchedMotion | None = None,
    inelastic: InelasticSpectrum | None = None,
    *,
    call: str = "",
) -> str:
    """The page of a ground motion: spectra at the damping ratios ``dampings``, their table at ``periods`` in s.

    A ``design`` spectrum is drawn beside that of the motion; ``matched`` is how the motion came to it, ``inelastic`` a
    spectrum of constant ductility in numbers, whose figure is made here.
    """
    drift = drift_in_words(motion)
    histories = FigureBlock(
        ground_histories(motion.time, motion.acceleration, motion.velocity, motion.displacement),
        "Acceleration and its exact integrals, from rest" + (f"; {drift}." if drift else "."),
    )
    processing = "\n\n".join(map(sentence, motion.history)) or "None: the samples are as they were read or generated."
    return page(
        motion.name,
        [
            Section("Intensity measures", [measures_table(measures(motion))]),
            Section("Over time", [histories]),
            Section(
                "Response spectra", [*_spectra(motion, dampings), spectrum_table(spectrum(motion, periods, dampings))]
            ),
            *([] if design is None else [_design_section(motion, design, periods)]),
            *([] if matched is None else [_matched_section(matched)]),
            *([] if inelastic is None else [_inelastic_section(motion, inelastic)]),
            Section("Processing", [Text(processing)]),
        ],
        subtitle=samples_in_words(motion),
        provenance={"source": motion.source or "not known"},
        call=call,
    )


def _matched_section(matched: MatchedMotion) -> Section:
    figure = FigureBlock(
        matched_figure(matched), "Pseudo-acceleration of the motion before and after, and the wanted one."
    )
    said = "\n\n".join(finding.sentence for finding in matched.findings)
    return Section("Matched spectrum", [*([Text(said)] if said else []), figure, matched_table(matched)])


def _inelastic_section(motion: GroundMotion, inelastic: InelasticSpectrum) -> Section:
    drawn = inelastic_spectrum(motion, inelastic.ductility, DRAWN, inelastic.damping, inelastic.hardening)
    figure = FigureBlock(
        inelastic_figure(drawn), "Yield strength over mass that limits the ductility, over the period."
    )
    said = "\n\n".join(finding.sentence for finding in inelastic.findings)
    return Section("Constant ductility", [*([Text(said)] if said else []), figure, inelastic_table(inelastic)])


def _design_section(motion: GroundMotion, design: DesignSpectrum | TableSpectrum, periods: Sequence[float]) -> Section:
    shortest = getattr(design, "periods", (0.0,))[0]
    drawn = [period for period in STANDARD_PERIODS if shortest <= period <= design.longest]
    figure = design_figure(compare_with_design(motion, design, drawn))
    return Section(
        "Design spectrum",
        [
            FigureBlock(figure, f"Pseudo-acceleration of the motion and of {design.name}."),
            design_table(compare_with_design(motion, design, periods)),
        ],
    )


def _spectra(motion: GroundMotion, dampings: Sequence[float]) -> list[FigureBlock]:
    spectra = spectrum(motion, damping=dampings)
    names = [f"{100 * damping:g} %" for damping in dampings]
    acceleration = response_spectrum(spectra.periods, dict(zip(names, spectra.pseudo_acceleration)))
    displacement = response_spectrum(spectra.periods, dict(zip(names, spectra.displacement)), SPECTRAL_DISPLACEMENT)
    return [
        FigureBlock(acceleration, "Pseudo-acceleration of an oscillator over its period, for each damping."),
        FigureBlock(displacement, "Its displacement relative to the ground."),
    ]
