"""What processes of tests do, functions of a module as `dampyr.processes.ChildProcess` calls them; and whether one is left."""

import os
import subprocess
import sys
import time
from multiprocessing.connection import Connection
from multiprocessing.process import current_process, parent_process
from pathlib import Path

from dampyr.processes import end_with


def add(first: Connection, second: Connection, a: int, b: int) -> None:
    first.send({"sum": a + b, "pid": os.getpid()})
    second.send(parent_process() is not None and current_process().pid == os.getpid())


def fail(connection: Connection) -> None:
    raise SystemExit(1)


def start_another(connection: Connection) -> None:
    """Start a process that would stay, and wait for the end."""
    end_with(connection)
    connection.send(subprocess.Popen([sys.executable, "-S", "-c", "import time; time.sleep(600)"]).pid)
    time.sleep(600.0)


def ignore_the_end(connection: Connection) -> None:
    connection.send("begun")
    time.sleep(600.0)


def wait_for_the_end(connection: Connection) -> None:
    end_with(connection)
    connection.send("begun")
    time.sleep(600.0)


def has_imported(connection: Connection, module: str) -> None:
    connection.send(module in sys.modules)


def alive(pid: int) -> bool:
    """Whether a process has not ended."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z" if Path("/proc").is_dir() else True
