"""A job that does nothing until it is cancelled, in a process of its own."""

import threading
from multiprocessing.connection import Connection
from pathlib import Path

from dampyr.console.limits import yield_to_rig
from dampyr.processes import end_with


def wait(connection: Connection, _: Path) -> None:
    """As a job does, it ends with its console."""
    end_with(connection)
    yield_to_rig()
    connection.send({"stage": "at work", "progress": 0.1})
    threading.Event().wait()
