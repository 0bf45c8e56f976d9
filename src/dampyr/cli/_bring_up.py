"""The person at a terminal, for the steps of a bring-up."""

from __future__ import annotations

import sys
import threading
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from dampyr.rig.bring_up import Answer, BringUpStep, Reading

ANSWERS: dict[str, Answer] = {"y": "go", "s": "skip", "q": "stop"}


class TerminalOperator:
    """An operator of `dampyr.rig.bring_up` who reads what to do and answers on the keyboard."""

    def __init__(self) -> None:
        self._typed: list[str] = []

    def begin(self, step: BringUpStep) -> Answer:
        """Ask before a step."""
        click.echo(f"\n{step.title}\n  Do: {step.do}.\n  To be seen: {step.see}.", err=True)
        if step.energised:
            click.echo(
                "  THIS STEP ENERGISES THE RIG: the enable line goes high, and the motor or the coil has power.",
                err=True,
            )
        kinds = click.Choice(list(ANSWERS))
        typed = click.prompt("Done, begin (y), skip this step (s), or end here (q)?", type=kinds, err=True)
        return ANSWERS[typed]

    def act(self, action: str, words: str) -> None:
        """Tell what to do now; a thread waits for Enter, so that the rig is read meanwhile."""
        self._typed.clear()
        click.echo(f"  Now {words}; then press Enter.", err=True)
        threading.Thread(target=lambda: self._typed.append(sys.stdin.readline().strip()), daemon=True).start()

    def done(self, seconds: float) -> str | None:
        """What was typed; None while nothing was."""
        return self._typed[-1] if self._typed else None

    def show(self, step: BringUpStep, verdict: str, readings: list[Reading], cause: str) -> None:
        """Show each reading with its limits, and the verdict."""
        for reading in readings:
            click.echo(f"  {'   ' if reading.passed else 'NO '}{reading}", err=True)
        click.echo(f"{step.name}: {verdict}{f': {cause}' if cause else ''}", err=True)
