"""Ensemble: many motions, scales, inputs and dampers at once; how likely a limit is exceeded."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._ensemble import EnsembleRequest, case_options, counting, limit, refuse_cases, shard
from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.structures import Fragility


@click.command()
@case_options
@click.option("--limit", "limits", multiple=True, metavar="L", help="12mm or 1% of drift, 0.5g; may be repeated.")
@click.option("--height", metavar="H", help="Of the storeys, such as 3m, for a limit in per cent.")
@click.option("--intensity", type=click.Choice(["pga", "sa", "scale"]), default="pga", help="[default: pga]")
@click.option(
    "--out", type=click.Path(path_type=Path), help="An .h5 file, taken up where it stopped; with --shard a folder."
)
@click.option("--shard", "part", metavar="I/N", help="Compute part I of N alone, into the folder --out.")
@click.option("--collect", type=click.Path(path_type=Path), metavar="DIR", help="Put the parts in a folder together.")
@click.option(
    "--read", type=click.Path(path_type=Path), metavar="FILE", help="Take a finished file instead of computing."
)
@click.option("--workers", type=click.IntRange(1), metavar="N", help="Threads.  [default: one for each core]")
@report_options()
@as_json_option
@click.pass_context
def command(
    context: click.Context,
    request: EnsembleRequest,
    limits: tuple[str, ...],
    height: str | None,
    intensity: str,
    out: Path | None,
    part: str | None,
    collect: Path | None,
    read: Path | None,
    workers: int | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Run a building through many earthquakes: peaks and fragility.

    CARD is a damper's card; without it the published damper of Raminelli (2020) is taken. Every damper runs at every input
    under every motion at every scale.
    """
    wanted = [limit(text, height) for text in limits]
    if height is not None and not any("height" in one for one in wanted):
        raise InputError("--height belongs to a limit in per cent; give --limit 1%, or leave --height out")
    if sum(each is not None for each in (part, collect, read)) > 1:
        raise InputError("--shard, --collect and --read exclude each other; give one of them")
    if part is not None:
        if wanted or report:
            raise InputError("a part alone tells nothing yet; give --limit and --report with --collect")
        _part(request, part, out, workers, as_json)
        return
    dataset = _dataset(context, request, out, collect, read, workers)
    from dampyr.structures import fragility

    curves = [fragility(dataset, intensity=intensity, seed=request.seed, **one) for one in wanted]
    if report:
        from dampyr.report.ensemble_page import write_ensemble_page

        write_ensemble_page(dataset, report, curves, intensity)
    if as_json:
        print_json(_as_dict(dataset, curves))
    else:
        _print(dataset, curves)


def _part(request: EnsembleRequest, text: str, out: Path | None, workers: int | None, as_json: bool) -> None:
    from dampyr.structures import write_part

    if out is None:
        raise InputError("--shard writes its part into a folder; name it with --out")
    with counting() as progress, ThreadPoolExecutor(workers) as pool:
        path = write_part(request.cases(), *shard(text), out, pool, progress)
    if as_json:
        print_json({"part": path})
    else:
        click.echo(str(path))


def _dataset(
    context: click.Context,
    request: EnsembleRequest,
    out: Path | None,
    collect: Path | None,
    read: Path | None,
    workers: int | None,
) -> Any:
    from dampyr import structures

    if collect is not None:
        refuse_cases(context, "--collect")
        return structures.collect(collect, out)
    if read is not None:
        refuse_cases(context, "--read")
        if out is not None:
            raise InputError("--read takes a finished file and --out writes one; give one of the two")
        return structures.read_ensemble(read)
    return _run(request, out, workers)


def _run(request: EnsembleRequest, out: Path | None, workers: int | None) -> Any:
    from dampyr.structures.ensemble import run
    from dampyr.structures.store import progress_of

    what = request.cases()
    done, shards = progress_of(out) if out is not None else (0, 0)
    if done:
        click.echo(f"{out}: {done} of {shards} shards are there; going on with the others", err=True)
    with counting(what.size * done // max(shards, 1)) as progress, ThreadPoolExecutor(workers) as pool:
        return run(what, pool, out, progress)


def _print(dataset: Any, curves: list[Fragility]) -> None:
    from dampyr.report import sentence
    from dampyr.report.ensemble_page import summary_rows, trust
    from dampyr.report.fragility_section import COLUMNS, fragility_rows, fragility_units, limit_in_words, remarks

    columns, units, rows = summary_rows(dataset)
    names = ", ".join(str(name) for name in dataset.building_name.values)
    print_table(f"{names}: peaks of {dataset.attrs['cases']} cases", columns, rows, units)
    for each in curves:
        click.echo()
        notes = [sentence(remark) for remark in remarks(each)]
        title = f"Fragility over {each.intensity}: {limit_in_words(each)}; 90 % bands over {each.motions} motions"
        print_table(title, COLUMNS, fragility_rows(each), fragility_units(each), notes=notes)
    click.echo()
    click.echo("\n".join(trust(dataset)))


def _as_dict(dataset: Any, curves: list[Fragility]) -> dict[str, Any]:
    from dampyr.structures import summary

    return {
        **dataset.attrs,
        "peaks": summary(dataset),
        "fragility": [
            {
                "quantity": each.quantity, "limit": each.limit, "limit_unit": each.limit_unit,
                "intensity": each.intensity, "intensity_unit": each.unit, "motions": each.motions,
                "curves": [_curve(curve) for curve in each.curves],
            }
            for each in curves
        ],
    }  # fmt: skip


def _curve(curve: Any) -> dict[str, Any]:
    return {
        "name": curve.name,
        "theta": curve.theta,
        "theta_band_90": curve.theta_band(),
        "beta": curve.beta,
        "reason": curve.reason,
        "no_band": curve.no_band,
        "direct": curve.direct,
        "never_exceeded": curve.capacities.above,
        "exceeded_at_once": curve.capacities.below,
        "cases": int(curve.of.sum()),
        "exceeding": int(curve.exceeding.sum()),
        "unbounded": curve.unbounded,
    }
