"""A console in a process of its own, ended by the keyboard."""

import os
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip("fastapi")
pytest.importorskip("uvicorn")


AT_A_KEYBOARD = """
import runpy, signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background ignores it
runpy.run_module("dampyr", run_name="__main__", alter_sys=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of the keyboard are POSIX's")
@pytest.mark.parametrize("times", [1, 2])
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
