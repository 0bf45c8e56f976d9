"""The command line: one file per command, found by its name.

A command is a file of this folder called as the command, with a click command (or group) named ``command``::

    \"""Print the mass of a damper.\"""

    import click

    from dampyr.cli._examples import examples
    from dampyr.cli._output import as_json_option, print_json, print_table


    @click.command(epilog=examples("dampyr mass damper.toml"))
    @click.argument("card", type=click.Path())
    @as_json_option
    def command(card: str, as_json: bool) -> None:
        \"""Print the mass of the damper in CARD.

        The first sentence stands in ``dampyr --help``.
        \"""
        from dampyr import models  # imported here, not above: help stays quick

        damper = models.Damper.load(card)
        ...
        if as_json:
            print_json({"name": ..., "mass_kg": ...})
        else:
            print_table("Mass", ["damper", "mass"], [[..., ...]], units=["", "kg"])

It parses, calls one public function of a package, and prints: nothing is computed here. Its help ends with examples, each of
which ``tests/cli/test_examples.py`` runs. An underscore in the
file's name is a hyphen in the command's. It may return an exit code; None is 0. A
:class:`dampyr.errors.DampyrError`, a file that cannot be opened and a wrong option end it with one line on
stderr and exit code 2; a :class:`dampyr.errors.DampyrWarning` is one line on stderr. Any other exception is a
fault of dampyr and shows its traceback. Progress belongs on stderr, so that ``--json`` leaves nothing else on
stdout.
"""

from dampyr.cli._forms import check_command, command_forms, perform_command
from dampyr.cli._frame import cli, main

__all__ = ["check_command", "cli", "command_forms", "main", "perform_command"]
