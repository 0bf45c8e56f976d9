"""The frame around all commands: finding them, and reducing errors to one line."""

from __future__ import annotations

import atexit
import gc
import os
import re
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, MutableMapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn, TextIO

import click

from dampyr import compiling, registry
from dampyr.cli._output import drop_unwritten
from dampyr.errors import DampyrError, DampyrWarning, choose_from
from dampyr.source_digest import full_version

REGISTRY = "dampyr.cli"
WRONG, INTERRUPTED = 2, 130  # exit codes as shells and click use them: a wrong request; 128 + SIGINT
SLOW = 1.0  # s of compiling after which a command says so
# Containers after which Python looks for garbage: by its own 700, 10, 10 it would look through a command's modules ten times.
COLLECTED_AFTER = (700, 100, 10)
SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


class CommandGroup(click.Group):
    """A group whose commands are the files of this folder, each loaded when it is needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the commands, as they are typed."""
        return [name.replace("_", "-") for name in registry.names(REGISTRY)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command called ``cmd_name``, or None."""
        if cmd_name not in self.list_commands(ctx):
            return None
        command: click.Command = registry.member(REGISTRY, cmd_name.replace("-", "_")).command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that ``args`` start with, or an error that names the nearest one."""
        names = self.list_commands(ctx)
        if args and args[0] not in names and not args[0].startswith("-"):
            raise click.UsageError(f"there is no command {args[0]!r}; {choose_from(args[0], names)}", ctx)
        return super().resolve_command(ctx, args)

    def main(self, args: Sequence[str] | None = None, *rest: Any, **extra: Any) -> NoReturn:
        """Run a command and leave the process with its exit code."""
        typed = tuple(sys.argv[1:] if args is None else args)
        extra |= {"standalone_mode": False, "prog_name": "dampyr", "obj": typed}  # pages say what made them
        sys.exit(_guarded(lambda: super(CommandGroup, self).main(args, **extra)))


def _print_version(ctx: click.Context, _: click.Parameter, is_set: bool) -> None:
    if is_set:
        click.echo(f"dampyr {full_version()}")
        ctx.exit()


@click.group(cls=CommandGroup, invoke_without_command=True, context_settings=SETTINGS)
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_print_version,
    help="Show the version, with the digest of the sources, and exit.",
)  # fmt: skip
@click.pass_context
def cli(ctx: click.Context) -> None:
    """Test, identify and simulate magnetorheological dampers: from the shaking table to the building."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main() -> NoReturn:
    """The ``dampyr`` command."""
    gc.set_threshold(*COLLECTED_AFTER)
    atexit.register(gc.freeze)  # else the end of the process waits 0.2 s for a last look through all modules
    open_streams()
    cli.main()


def open_streams() -> None:
    """Open those of stdin, stdout and stderr that the shell has closed (``<&-``), on the null device.

    Else the next file that is opened, such as a record, would be the one that stray output is written to.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the system gives the lowest number that is free
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115


def _guarded(run: Callable[[], Any]) -> int:
    """The exit code of ``run``; what is wrong for a known reason is said in one line."""
    try:
        with _warnings_in_one_line(), compilation_notice():
            code = run()
        return code if isinstance(code, int) else 0
    except click.exceptions.NoArgsIsHelpError as problem:
        problem.show()
        return WRONG
    except click.ClickException as problem:
        context = getattr(problem, "ctx", None)
        where = f"; see `{context.command_path} --help`" if context else ""
        return say(problem.format_message().rstrip(".?") + where)
    except DampyrError as problem:
        return say(with_notes(problem))
    except BrokenPipeError:  # the reader left
        drop_unwritten()
        return 1
    except OSError as problem:
        drop_unwritten()
        return say(f"{problem.filename}: {problem.strerror}" if problem.filename else str(problem))
    except (click.Abort, KeyboardInterrupt):
        say("interrupted")
        return INTERRUPTED


def with_notes(problem: BaseException) -> str:
    """The message of an error, and what was noted on it, in one line."""
    return "; ".join([str(problem), *getattr(problem, "__notes__", [])])


# Messages that name arguments of Python, and the options that a terminal has for them.
ARGUMENT = r"\w+=(?:\{[^}]*\}|'[^']*'|[\w.]*)"
OPTIONS = tuple(
    (re.compile(pattern), words)
    for pattern, words in (
        (r"\bpass allow_extrapolation=True", "add --allow-extrapolation"),
        (r"\bread it with voltage= \(or current=\)", "declare it with --voltage (or --current)"),
        (r"\bis read with no_input=True", "is declared with --no-input"),
        (r"\bdeclare it, such as units='([^']*)'( or units='[^']*')?", r"declare it with --motion-unit \1"),
        (r"\bgive the seconds between samples, such as dt=([\d.]+)", r"give the seconds between samples with --dt \1"),
        # "--dt 0.02 or dt=0.02", "--motion-unit g, units='g' or units='m/s^2'", "--column a=0 --column b=1 or columns={...}"
        (rf"(--\w[\w-]*(?: (?:'[^']*'|[^\s,;]+)){{1,4}}?)(?:,| or) {ARGUMENT}(?: or {ARGUMENT})?", r"\1"),
    )
)


def in_option_words(sentence: str) -> str:
    """The sentence as it is typed in a terminal."""
    for pattern, words in OPTIONS:
        sentence = pattern.sub(words, sentence)
    return sentence


def say(message: str) -> int:
    """One line on stderr, where it can be written; whether it can is no matter of the work under way."""
    with suppress(OSError, ValueError):
        click.echo(f"dampyr: {in_option_words(' '.join(message.split()))}", err=True)
    return WRONG


@contextmanager
def compilation_notice() -> Iterator[None]:
    """Say in one line on stderr, where that is a terminal, that kernels are compiled, once they have been for `SLOW` seconds.

    It is for a person who waits: whether one does is decided here, and logs, pipes and tests see nothing. Processes that a
    command starts compile without a word.
    """
    if not sys.stderr.isatty():
        yield
        return
    spent, began, said = 0.0, 0.0, False
    timer: threading.Timer | None = None

    def speak() -> None:
        nonlocal said
        said = True
        say(
            "compiling, once: later runs find the machine code on disk; `dampyr doctor --warm` compiles the usual ahead"
        )

    def note(begins: bool) -> None:
        nonlocal spent, began, timer
        if timer is not None:
            timer.cancel()
        if begins and not said:
            began = time.monotonic()
            timer = threading.Timer(max(SLOW - spent, 0.0), speak)
            timer.daemon = True
            timer.start()
        elif not begins:
            spent += time.monotonic() - began

    try:
        with compiling.watched(note):
            yield
    finally:
        if timer is not None:
            timer.cancel()


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Print each warning of dampyr's own once, in one line; leave the others as they are."""
    seen: MutableMapping[str, None] = {}

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if not issubclass(category, DampyrWarning):
            others(message, category, filename, lineno, file, line)
        elif str(message) not in seen:
            seen[str(message)] = None
            say(f"warning: {message}")

    with warnings.catch_warnings():
        others = warnings.showwarning
        warnings.filterwarnings("always", category=DampyrWarning)
        warnings.showwarning = show
        yield
