"""The console: the operator's page in a browser, served from this machine and working without a network.

``dampyr console`` calls `serve`; `app` is the same as an ASGI application. What its pages do goes through the public
functions of the other packages, as the commands do.

A page is two files: ``pages/NAME.py`` with what it answers (see :mod:`dampyr.console.pages`) and ``static/pages/NAME.js``
with what it shows. Long work is a file of ``jobs``, run in a process of its own (:mod:`dampyr.console.job_processes`).
"""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from dampyr.errors import InputError, install_line

FUNCTIONS = {"app": "application", "serve": "http_server"}
"""The public functions and their modules, loaded when they are used: a job's process needs neither, nor the web server."""

NEEDED = {"fastapi": "fastapi", "uvicorn": "uvicorn", "websockets": "websockets"}
"""The packages of the extra ``console`` without which no page is served, by their modules' names; charts say what they need."""


def __getattr__(name: str) -> Any:
    if name not in FUNCTIONS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    absent = [package for package, module in NEEDED.items() if find_spec(module) is None]
    if absent:
        raise InputError(f"the console needs {' and '.join(absent)}; install it: {install_line('console')}")
    return getattr(import_module(f"{__name__}.{FUNCTIONS[name]}"), name)


__all__ = [*FUNCTIONS]
