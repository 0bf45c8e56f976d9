"""The console: the operator's page in a browser, served from this machine and working without a network.

``dampyr console`` calls `serve`; `app` is the same as an ASGI application. What its pages do goes through the public
functions of the other rooms, as the commands do.

A page is two files: ``pages/NAME.py`` with what it answers (see :mod:`dampyr.console.pages`) and ``static/pages/NAME.js``
with what it shows. Long work is a file of ``work``, run in a process of its own (:mod:`dampyr.console.job_processes`).
"""

from dampyr.console.app import app
from dampyr.console.serve import serve

__all__ = ["app", "serve"]
