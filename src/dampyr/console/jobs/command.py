"""A command of the terminal, performed in the data folder."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import chdir
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from dampyr.console.command_words import COMMAND_LINE, CommandRequest, command_line
from dampyr.console.equivalent_commands import typed_command
from dampyr.console.jobs import FIGURES, FILES, PAGE
from dampyr.console.page_tables import page_table
from dampyr.console.page_words import in_page_words
from dampyr.console.safe_paths import data_of, files

PAGE_LINE = "page: "  # with which a command says where its page is, for which this page has a button


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `CommandRequest`; what the command writes lies in the folders `FILES` and `FIGURES` of the job."""
    data, written = data_of(folder), folder / FILES
    place = folder.relative_to(data).as_posix()
    line = command_line(CommandRequest(**request), data, place)
    written.mkdir(exist_ok=True)
    (folder / FIGURES).mkdir(exist_ok=True)
    with chdir(data):
        output = import_module(COMMAND_LINE).perform_command(line.run, line.typed, progress)

    def words(text: str) -> str:
        """A sentence as it is read on a page: without the job's folder in the places of what was written."""
        return in_page_words(text.replace(f"{place}/{FILES}/", "").replace(f"{place}/", ""))

    def shown(entry: Any) -> dict[str, Any]:
        if isinstance(entry, str):
            return {"text": words(entry)}
        sentences = {"caption": words(entry.caption), "notes": [words(note) for note in entry.notes]}
        return {"table": page_table(replace(entry, **sentences))}

    return {
        "command": typed_command(line.typed),
        "notice": output.notice,
        "output": [shown(entry) for entry in output.entries if not str(entry).startswith(PAGE_LINE)],
        "figures": files(folder / FIGURES, (".svg",)),
        "files": sorted(path.relative_to(written).as_posix() for path in written.rglob("*") if path.is_file()),
        "page": (folder / PAGE).is_file(),
    }
