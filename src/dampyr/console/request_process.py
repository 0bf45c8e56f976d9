"""Process that answers one request: within the limits of its memory, time and output, it calls a function and sends its result.

What goes back is JSON, as the page gets it: a process that has read the file of a stranger sends nothing that could be run.
"""

from __future__ import annotations

import errno
import json
import traceback
import warnings
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import Any

from dampyr.console.limits import RequestLimits, yield_to_rig
from dampyr.errors import DampyrError, MissingData
from dampyr.processes import end_with

FORKED = "dampyr.console.forked_imports"  # of its process and of a job's
MAX_REASON = 600  # characters: a sentence for a person, whatever a file's header holds
MAX_ANSWER = 64 * 2**20  # bytes of one message: the lines of six records take a tenth


def answer(
    connection: Connection, limits: RequestLimits, function: Callable[..., Any], arguments: tuple[Any, ...]
) -> None:
    """Call ``function`` and send what comes of it: the ``result``, after a ``part`` for each item of a generator; ``refused``
    with a sentence; or ``fault`` for an error of dampyr, whose traceback is printed.
    """

    def send(**message: Any) -> None:
        text = json.dumps(message).encode()
        if len(text) > MAX_ANSWER:
            too_large = f"the answer has more than {MAX_ANSWER // 2**20} MiB; request less at once"
            text = json.dumps({"refused": too_large}).encode()
        connection.send_bytes(text)

    end_with(connection)
    yield_to_rig()
    limits.apply()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = function(*arguments)
            if isinstance(result, Iterator):
                for part in result:
                    send(part=part)
                result = None
            send(result=result)
    except DampyrError as problem:
        text = str(problem)
        sentence = text if len(text) <= MAX_REASON else f"{text[: MAX_REASON - 2]} …"
        send(refused=sentence, missing=isinstance(problem, MissingData))
    except (MemoryError, RecursionError):
        send(refused=limits.too_much)
    except Exception as problem:
        if isinstance(problem, OSError) and problem.errno in (errno.EFBIG, errno.EDQUOT):
            send(refused="it writes more than a request may; request less at once")
        else:
            traceback.print_exc()
            send(fault=True)
