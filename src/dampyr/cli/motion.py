"""Motion: how strong an earthquake is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._motion import Ground, motion_options, ratio
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, print_json, print_result
from dampyr.cli._report import report_options

if TYPE_CHECKING:
    from dampyr.ground_motions import GroundMotion, MotionReadOptions
    from dampyr.ground_motions.intensity_measures import Measures
    from dampyr.ground_motions.response_spectrum import Spectrum


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.ground_motions:MotionReadOptions"},
    first=2,
    epilog=examples(
        "dampyr motion --pga 0.3g --report motion.html", "dampyr motion kobe.csv --motion-unit g --dt 0.02"
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
@report_options()
@as_json_option
def command(
    file: Path | None,
    ground: Ground,
    options: MotionReadOptions,
    baseline: bool,
    dampings: tuple[str, ...],
    periods: tuple[float, ...],
    report: Path | None,
    as_json: bool,
) -> None:
    """Tell how strong an earthquake is: its peaks and its spectrum.

    FILE is a ground motion; without it El Centro 1940 is taken.
    """
    from dampyr.ground_motions import measures, spectrum
    from dampyr.show.pages import motion_page
    from dampyr.show.pages.result_page import write_page

    motion = ground.motion(file, baseline, options)
    table_periods, ratios = periods or motion_page.TABLE, [ratio(text) for text in dampings]
    motion_measures = measures(motion)
    peaks = spectrum(motion, table_periods, ratios or [0.05])
    if report:
        write_page(motion, report, dampings=ratios or motion_page.DAMPINGS, periods=table_periods)
    if as_json:
        print_json(_as_dict(motion, motion_measures, peaks))
        return
    print_result(motion)
    click.echo()
    print_result(peaks)


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
