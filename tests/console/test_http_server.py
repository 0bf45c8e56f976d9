"""A server of the console: its address, its port, and how the keyboard ends it."""

import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest

pytest.importorskip("fastapi")
pytest.importorskip("uvicorn")
import uvicorn
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.console import http_server

AT_A_KEYBOARD = """
import runpy, signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background ignores it
runpy.run_module("dampyr", run_name="__main__", alter_sys=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of the keyboard are POSIX's")
@pytest.mark.parametrize("times", [pytest.param(1, marks=pytest.mark.prove), 2])
def test_the_keyboard_ends_it_without_a_traceback(data, times):
    command = [sys.executable, "-c", AT_A_KEYBOARD, "console", "--port", "0", "--no-browser", "--data", str(data)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert process.stdout is not None
    assert "Ctrl+C ends it" in process.stdout.readline()
    time.sleep(1.0)
    for _ in range(times):
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
    _, errors = process.communicate(timeout=60)
    assert "Traceback" not in errors
    assert process.returncode == 130


@pytest.fixture
def console(monkeypatch, data):
    """``console("--port", "0")``: the command in this process, which ends as soon as it would serve."""
    monkeypatch.setattr(uvicorn.Server, "run", lambda *_, sockets: [listening.close() for listening in sockets])
    monkeypatch.setattr(http_server, "begin_to_import", lambda _: None)
    monkeypatch.setattr("dampyr.rig.priority.before_ordinary", lambda: None)
    return lambda *words: CliRunner().invoke(cli, ["console", *words, "--data", str(data), "--no-browser"])


def test_another_address_asks_for_the_token_it_printed(console):
    printed = console("--host", "0.0.0.0", "--port", "0").stdout
    assert re.search(r"\?token=[\w-]{32} ", printed)


def test_a_port_that_is_taken_is_one_line(console):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        done = console("--port", port)
    assert done.exit_code == 2
    assert re.fullmatch(
        rf"dampyr: 127\.0\.0\.1, port {port} cannot be had \(.*\); choose another --port or --host\n", done.stderr
    )
