"""Errors as responses: one sentence, without internals of the machine."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from dampyr.console.page_words import in_page_words
from dampyr.errors import DampyrError, MissingData

LOG = logging.getLogger("dampyr.console")
MAX_SENTENCE = 600  # characters that a person reads
MAX_TEXT = 20_000  # characters that are looked at: a message that lists a file's names may have millions
FAULT = "something went wrong inside dampyr; see the console's own output"


def add_handlers(to: FastAPI, data: Path) -> None:
    """Make every error that leaves an endpoint of ``to`` one sentence."""

    async def answer_dampyr_error(request: Request, problem: Exception) -> JSONResponse:
        code = 404 if isinstance(problem, MissingData) else 400
        return answer(code, in_page_words(without_places(str(problem)[:MAX_TEXT], data)))

    async def refused(request: Request, problem: Exception) -> JSONResponse:
        assert isinstance(problem, HTTPException)
        return answer(problem.status_code, str(problem.detail), problem.headers)

    async def misread(request: Request, problem: Exception) -> JSONResponse:
        assert isinstance(problem, RequestValidationError)
        return answer(422, first_of(problem))

    async def fault(request: Request, problem: Exception) -> JSONResponse:
        LOG.error("%s %s", request.method, request.url.path, exc_info=problem)
        return answer(500, FAULT)

    to.add_exception_handler(DampyrError, answer_dampyr_error)
    to.add_exception_handler(HTTPException, refused)
    to.add_exception_handler(RequestValidationError, misread)
    to.add_exception_handler(Exception, fault)


def answer(code: int, sentence: str, headers: Any = None) -> JSONResponse:
    """An error's answer: ``{"detail": sentence}``."""
    words = " ".join(sentence[:MAX_TEXT].split())
    return JSONResponse(
        {"detail": words if len(words) <= MAX_SENTENCE else f"{words[: MAX_SENTENCE - 2]} …"}, code, headers
    )


def without_places(sentence: str, data: Path) -> str:
    """The sentence with paths below the data folder relative to it, and of other folders the file's name alone."""
    for root in {str(data), str(data.resolve())}:
        sentence = sentence.replace(f"{root}/", "").replace(root, "the data folder")
    return " ".join(_name_only(word) for word in sentence.split(" "))


def _name_only(word: str) -> str:
    core = word.strip("'\"(),;")
    is_place = (core.startswith("/") and core.count("/") > 1) or core[1:3] == ":\\"
    return word.replace(core, core.replace("\\", "/").rpartition("/")[2]) if is_place else word


def first_of(problem: RequestValidationError) -> str:
    """The first thing that is wrong with a request, such as ``scale: Input should be greater than 0``."""
    first = problem.errors()[0]
    where = ".".join(str(part) for part in first["loc"] if part not in ("body", "query", "path"))
    words = str(first["msg"]).removeprefix("Value error, ")  # of a check of ours, which names what it is of
    return f"{where}: {words}" if where and words == first["msg"] else words
