"""A command of the terminal, performed in the data folder."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import chdir
from importlib import import_module
from pathlib import Path
from typing import Any

from dampyr.console.command_words import COMMAND_LINE, CommandRequest, words_of
from dampyr.console.equivalent_commands import typed_command
from dampyr.console.jobs import FIGURES, FILES, PAGE
from dampyr.console.page_words import in_page_words
from dampyr.console.safe_paths import data_of, files
from dampyr.show.pages.typography import as_words


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `CommandRequest`; what the command writes lies in the folders `FILES` and `FIGURES` of the job."""
    data = data_of(folder)
    words = words_of(CommandRequest(**request), data, folder.relative_to(data).as_posix())
    for made in (FILES, FIGURES):
        (folder / made).mkdir(exist_ok=True)
    with chdir(data):
        answers = import_module(COMMAND_LINE).perform_command(words.run, words.typed, progress)
    return {
        "command": typed_command(words.typed),
        "answers": [
            _in_page_words(answer, folder, data)
            for answer in answers
            if not answer.get("text", "").startswith("page: ")
        ],
        "figures": files(folder / FIGURES, (".svg",)),
        "files": sorted(
            path.relative_to(folder / FILES).as_posix() for path in (folder / FILES).rglob("*") if path.is_file()
        ),
        "page": (folder / PAGE).is_file(),
    }


def _in_page_words(answer: dict[str, Any], folder: Path, data: Path) -> dict[str, Any]:
    """A table or a line as it is read on a page: the job's folder is left out of the places of what was written."""
    place = f"{folder.relative_to(data).as_posix()}/"

    def words(text: str) -> str:
        return in_page_words(text.replace(f"{place}{FILES}/", "").replace(place, ""))

    if answer["kind"] == "text":
        return answer | {"text": words(answer["text"])}
    return answer | {
        "caption": words(answer["caption"]),
        "notes": [words(note) for note in answer["notes"]],
        "rows": [[as_words(cell) if isinstance(cell, str) else cell for cell in row] for row in answer["rows"]],
    }
