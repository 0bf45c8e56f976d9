"""Motion: how strong an earthquake is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._frame import in_option_words
from dampyr.cli._motion import Ground, motion_options, ratio
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, print_json, print_result
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.ground_motions import DesignSpectrum, GroundMotion, MotionReadOptions, TableSpectrum
    from dampyr.ground_motions.constant_ductility import InelasticSpectrum
    from dampyr.ground_motions.intensity_measures import Measures
    from dampyr.ground_motions.response_spectrum import Spectrum
    from dampyr.ground_motions.spectrum_matching import MatchedMotion


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.ground_motions:MotionReadOptions"},
    first=2,
    epilog=examples(
        "dampyr motion --pga 0.3g --report motion.html",
        "dampyr motion kobe.csv --motion-unit g --dt 0.02",
        "dampyr motion --design ec8:ag=0.3g,ground=C --fit-design 0.2:2",
        "dampyr motion --design ec8:ag=0.3g,ground=C --match 0.1:4 --save matched.csv",
        "dampyr motion --ductility 2 --ductility 4 --period 0.5 --period 1",
        "dampyr motion motions --period 0.5",
    ),
)
@click.argument("file", required=False, type=click.Path(path_type=Path))
@motion_options
@click.option("--baseline", is_flag=True, help="Take the baseline off first, so that the displacement does not drift.")
@click.option(
    "--damping", "dampings", multiple=True, metavar="D", help="Damping of the spectrum, such as 2%; may be repeated."
)
@click.option(
    "--period", "periods", multiple=True, type=float, metavar="S", help="Period of the spectrum; may be repeated."
)
@click.option(
    "--design",
    metavar="CODE",
    help="Design spectrum beside it: asce7:sds=1g,sd1=0.6g,tl=8s, ec8:ag=0.25g,ground=C,type=1,damping=5% or "
    "table:FILE,unit=g,damping=5%.",
)
@click.option(
    "--fit-design",
    "fit_range",
    metavar="T1:T2",
    help="Scale the motion to the design spectrum by least squares between these periods in s, such as 0.2:2.",
)
@click.option(
    "--match",
    "match_range",
    metavar="T1:T2",
    help="Match the motion to the design spectrum by wavelets between these periods in s, such as 0.1:4.",
)
@click.option(
    "--save",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write the motion, time and acceleration, as a text file.",
)
@click.option(
    "--ductility",
    "ductilities",
    multiple=True,
    type=float,
    metavar="MU",
    help="Spectrum of yield strengths that limit the ductility to this; may be repeated.",
)
@click.option("--hardening", metavar="R", help="Stiffness after yielding for --ductility, such as 3%.  [default: 0]")
@report_options()
@as_json_option
def command(
    file: Path | None,
    ground: Ground,
    options: MotionReadOptions,
    baseline: bool,
    dampings: tuple[str, ...],
    periods: tuple[float, ...],
    design: str | None,
    fit_range: str | None,
    match_range: str | None,
    save: Path | None,
    ductilities: tuple[float, ...],
    hardening: str | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Tell how strong an earthquake is: its peaks and its spectrum.

    FILE is a ground motion; without it El Centro 1940 is taken. Of a folder, or of a file with several components of which
    none is chosen, it tells what is in it, and the spectra RotD50 and RotD100 of each pair of horizontal components.
    """
    from dampyr.ground_motions import compare_with_design, measures, spectrum
    from dampyr.ground_motions.design_spectra import parse_design
    from dampyr.ground_motions.motion_files import component_names
    from dampyr.options import command_words
    from dampyr.show.pages import motion_page
    from dampyr.show.pages.result_page import write_page

    if file is not None and (file.is_dir() or (ground.component is None and len(component_names(file)) > 1)):
        of_one = {
            "baseline": baseline,
            "report": report,
            "design": design,
            "fit-design": fit_range,
            "match": match_range,
            "save": save,
            "ductility": ductilities or None,
            "hardening": hardening,
            **{f"{w[2:]}": True for w in command_words(options)[:1]},
        }
        _print_folder(file, ground, of_one, dampings, periods, as_json)
        return
    code = None if design is None else parse_design(design)
    motion, matched = _chosen(ground, ground.motion(file, baseline, options), code, fit_range, match_range)
    table_periods, ratios = periods or motion_page.TABLE, [ratio(text) for text in dampings]
    motion_measures = measures(motion)
    peaks = spectrum(motion, table_periods, ratios or [0.05])
    compared = None if code is None else compare_with_design(motion, code, table_periods)
    yielding = _inelastic(motion, ductilities, hardening, ratios, table_periods)
    if save:
        motion.save(save)
    if report:
        write_page(
            motion, report, dampings=ratios or motion_page.DAMPINGS, periods=table_periods, design=code, matched=matched,
            inelastic=yielding,
        )  # fmt: skip
    beside = {"matched": matched, "design": compared, "inelastic": yielding}
    if as_json:
        told = {name: result.as_dict() for name, result in beside.items() if result is not None}
        print_json(_as_dict(motion, motion_measures, peaks) | told)
        return
    print_result(motion)
    click.echo()
    print_result(peaks)
    for result in beside.values():
        if result is not None:
            click.echo()
            print_result(result)


def _chosen(
    ground: Ground,
    motion: GroundMotion,
    code: DesignSpectrum | TableSpectrum | None,
    fit_range: str | None,
    match_range: str | None,
) -> tuple[GroundMotion, MatchedMotion | None]:
    """The motion as it was read, or fitted or matched to the design spectrum; of the latter what came of it."""
    if fit_range is not None:
        if any(value is not None for value in (ground.scale, ground.pga, ground.sa)):
            raise InputError("--fit-design scales the motion; leave --scale, --pga and --sa out")
        if match_range is None:
            return _fitted(motion, code, fit_range), None
    if match_range is None:
        return motion, None
    matched = _matched(motion, code, ground, match_range, fit_range)
    return matched.motion, matched


def _fitted(motion: GroundMotion, code: DesignSpectrum | TableSpectrum | None, text: str) -> GroundMotion:
    """The motion scaled to the design spectrum between the periods ``T1:T2``."""
    from dampyr.ground_motions import scaled_to_design

    return scaled_to_design(motion, *_design_and_range(code, text, "fit-design", "0.2:2"))


def _matched(
    motion: GroundMotion,
    code: DesignSpectrum | TableSpectrum | None,
    ground: Ground,
    text: str,
    fit_range: str | None,
) -> MatchedMotion:
    """The motion matched to the design spectrum between the periods ``T1:T2``."""
    from dampyr.ground_motions import matched_to_design

    if any(value is not None for value in (ground.scale, ground.pga, ground.sa, fit_range)):
        raise InputError("--match scales the motion; leave --scale, --pga, --sa and --fit-design out")
    return matched_to_design(motion, *_design_and_range(code, text, "match", "0.1:4"))


def _inelastic(
    motion: GroundMotion,
    ductilities: tuple[float, ...],
    hardening: str | None,
    dampings: list[float],
    periods: Sequence[float],
) -> InelasticSpectrum | None:
    """The spectrum of constant ductility, where one is asked for."""
    from dampyr.ground_motions import inelastic_spectrum

    if hardening is not None and not ductilities:
        raise InputError("--hardening belongs to --ductility; give one, such as --ductility 4, or leave it out")
    if not ductilities:
        return None
    if len(dampings) > 1:
        raise InputError("--ductility is for one --damping; leave the others out")
    damping = dampings[0] if dampings else 0.05
    return inelastic_spectrum(motion, ductilities, periods, damping, ratio(hardening) if hardening else 0.0)


def _design_and_range(
    code: DesignSpectrum | TableSpectrum | None, text: str, option: str, example: str
) -> tuple[DesignSpectrum | TableSpectrum, float, float]:
    """The design spectrum, and the range of periods ``T1:T2`` in s, of an option that needs both."""
    from dampyr.units import parse

    if code is None:
        raise InputError(f"--{option} needs a design spectrum; give it, such as --design ec8:ag=0.25g,ground=C")
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"--{option} {text!r} is not a range of periods; write it as in {example}, in s")
    return code, parse(low, "s"), parse(high, "s")


def _print_folder(
    path: Path,
    ground: Ground,
    given: dict[str, Any],
    dampings: tuple[str, ...],
    periods: tuple[float, ...],
    as_json: bool,
) -> None:
    """What is in a folder, or in a file with several components; ``given`` are options that are of one motion."""
    from dampyr.ground_motions import read_folder, rotated_spectrum
    from dampyr.show.pages.motion_page import TABLE

    given |= {name: getattr(ground, name) for name in ("component", "scale", "pga", "sa")}
    wrong = [f"--{name}" for name, value in given.items() if value not in (None, False)]
    if wrong:
        repair = "name one of its files" if path.is_dir() else "choose one with --component"
        raise InputError(f"{path}: {wrong[0]} is of one motion; {repair}")
    table = read_folder(path, ground.unit, ground.dt)
    ratios = [ratio(text) for text in dampings] or [0.05]
    spectra = [
        rotated_spectrum(first, second, periods or TABLE, damping)
        for first, second in table.horizontal_pairs
        for damping in ratios
    ]
    if as_json:
        print_json({**table.as_dict(), "rotated": [spectrum.as_dict() for spectrum in spectra]})
        return
    entries = tuple(replace(entry, problem=in_option_words(entry.problem)) for entry in table.entries)
    print_result(replace(table, entries=entries))
    for spectrum in spectra:
        click.echo()
        print_result(spectrum)


def _as_dict(motion: GroundMotion, motion_measures: Measures, peaks: Spectrum) -> dict[str, Any]:
    return {
        "name": motion.name,
        "source": motion.source,
        "history": motion.history,
        "samples": motion.n,
        "dt_s": motion.dt,
        "duration_s": motion.duration,
        "pga_m_s2": motion_measures.pga,
        "pgv_m_s": motion_measures.pgv,
        "pgd_m": motion_measures.pgd,
        "arias_m_s": motion_measures.arias,
        "duration_5_95_s": motion_measures.duration_5_95,
        "duration_5_75_s": motion_measures.duration_5_75,
        "cumulative_absolute_velocity_m_s": motion_measures.cumulative_absolute_velocity,
        "spectrum": {
            "damping": peaks.damping,
            "period_s": peaks.periods,
            "displacement_m": peaks.displacement,
            "velocity_m_s": peaks.velocity,
            "acceleration_m_s2": peaks.acceleration,
            "pseudo_velocity_m_s": peaks.pseudo_velocity,
            "pseudo_acceleration_m_s2": peaks.pseudo_acceleration,
        },
    }
