"""Console: the operator's page in a browser."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json
from dampyr.errors import InputError, install_line


@click.command(
    epilog=examples(
        "dampyr console",
        "dampyr console --data lab --port 8080 --no-browser",
    )
)
@click.option(
    "--host", default="127.0.0.1", show_default=True, help="The address; one that others can reach needs a token."
)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8077, show_default=True, help="The port; 0 takes a free one."
)
@click.option(
    "--data", type=click.Path(path_type=Path), default=Path("dampyr-data"), show_default=True, metavar="DIR",
    help="The folder of records, cards and campaigns, in which the console writes, too.",
)  # fmt: skip
@click.option(
    "--token", metavar="TEXT", envvar="DAMPYR_TOKEN", help="What a browser must present; by default made where needed."
)
@click.option(
    "--quota", type=click.IntRange(1), default=4096, show_default=True, metavar="MIB", help="Limit of the data folder."
)
@click.option("--no-browser", is_flag=True, help="Print the address, and open no browser.")
@as_json_option
def command(host: str, port: int, data: Path, token: str | None, quota: int, no_browser: bool, as_json: bool) -> None:
    """Serve the console, the operator's page, until it is interrupted.

    It prints its address. It serves this machine alone unless --host says otherwise; then a browser must tell a token, which
    is in the address that is printed.
    """
    try:
        from dampyr.console import serve
        from dampyr.rig.priority import before_ordinary
    except ModuleNotFoundError as problem:
        raise InputError(
            f"the console needs {problem.name}, which is missing; install it: {install_line('console')}"
        ) from None

    def tell(address: str) -> None:
        if as_json:
            print_json({"address": address, "data": data})
        else:
            click.echo(f"the console is at {address} (Ctrl+C ends it)")

    before_ordinary()
    serve(data, host, port, token, not no_browser, quota * 2**20, tell)
