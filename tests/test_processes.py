"""Processes of dampyr's own: what runs there, how each ends, and that none outlives the process that started it."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from multiprocessing import forkserver
from pathlib import Path

import pytest

pytest.importorskip("fastapi")
from dampyr.console.request_process import FORKED
from dampyr.processes import ChildProcess
from tests import process_functions
from tests.process_functions import alive

ROOT = Path(__file__).resolve().parents[1]
POSIX = pytest.mark.skipif(os.name != "posix", reason="signals and sessions of POSIX")
pytestmark = pytest.mark.parametrize("forked", ["", FORKED], ids=["started", "copied"])


def test_a_function_of_a_module_answers_over_its_pipes(forked: str) -> None:
    child = ChildProcess(process_functions.add, 2, 3, pipes=2, forked=forked)
    first, second = child.connections
    assert first.recv() == {"sum": 5, "pid": child.pid}
    assert second.recv() == (child.pid != os.getpid())
    with pytest.raises(EOFError):
        first.recv()
    assert child.wait() == 0
    child.end()
    assert first.closed
    assert second.closed


def test_an_error_there_is_the_end_and_a_status(forked: str) -> None:
    child = ChildProcess(process_functions.fail, forked=forked)
    with pytest.raises(EOFError):
        child.connections[0].recv()
    assert child.wait() == 1
    child.end()


@POSIX
def test_a_killed_process_takes_along_what_it_has_started(forked: str) -> None:
    child = ChildProcess(process_functions.start_another, forked=forked)
    grandchild = child.connections[0].recv()
    assert alive(grandchild)
    assert child.wait(0.0) is None
    child.kill()
    assert child.wait(10.0) == -signal.SIGKILL
    wait_for_end(grandchild)
    child.kill()  # one that has ended is left alone
    child.end()


def test_a_process_that_does_not_end_when_it_is_asked_is_killed(forked: str) -> None:
    child = ChildProcess(process_functions.ignore_the_end, forked=forked)
    child.connections[0].recv()
    child.end(patience=0.1)
    assert child.wait(0.0) != 0
    assert child.connections[0].closed


@POSIX
def test_a_thread_that_waits_at_a_pipe_does_not_keep_it_open(forked: str) -> None:
    child = ChildProcess(process_functions.wait_for_the_end, forked=forked)
    (connection,) = child.connections
    assert connection.recv() == "begun"
    ended = threading.Event()

    def receive() -> None:
        with pytest.raises(EOFError):
            connection.recv()
        ended.set()

    threading.Thread(target=receive, daemon=True).start()
    time.sleep(0.05)
    child.hang_up()
    assert ended.wait(30.0)
    assert child.wait(30.0) == -signal.SIGKILL  # it ends itself, with all that it has started
    child.end()


SCRIPT = textwrap.dedent("""
    import signal, sys, time
    from dampyr.processes import ChildProcess
    from tests import process_functions

    signal.signal(signal.SIGINT, signal.default_int_handler)  # it is ignored below a shell's background job
    print("run", flush=True)
    child = ChildProcess(process_functions.start_another, forked=sys.argv[1])
    print(child.pid, child.connections[0].recv(), flush=True)
    if sys.argv[2] == "waits":
        time.sleep(60.0)
""")


@POSIX
@pytest.mark.parametrize("how", ["killed", "interrupted", "at its end"])
def test_none_outlives_a_script_without_a_guard_which_runs_once(forked: str, how: str, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    waits = "waits" if how != "at its end" else "ends"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
    with subprocess.Popen(
        [sys.executable, str(script), forked, waits], stdout=subprocess.PIPE, env=environment, text=True
    ) as host:
        assert host.stdout is not None
        assert host.stdout.readline() == "run\n"
        numbers = [int(number) for number in host.stdout.readline().split()]
        if how == "killed":
            host.kill()
        elif how == "interrupted":
            host.send_signal(signal.SIGINT)
        rest = host.stdout.read() if how == "at its end" else ""
        host.wait(30.0)
    assert rest == ""
    for number in numbers:
        wait_for_end(number)


@POSIX
def test_a_ctrl_c_at_the_terminal_does_not_reach_it(forked: str) -> None:
    child = ChildProcess(process_functions.wait_for_the_end, forked=forked)
    child.connections[0].recv()
    assert os.getsid(child.pid) == os.getpgid(child.pid) == child.pid
    child.end()


def test_a_copy_has_what_its_origin_has_imported(forked: str) -> None:
    child = ChildProcess(process_functions.has_imported, "dampyr.console.campaign_plans", forked=forked)
    assert child.connections[0].recv() == bool(forked and sys.platform == "linux")
    child.end()


@POSIX
def test_a_process_to_be_copied_that_was_killed_is_started_again(forked: str) -> None:
    for _ in range(2):
        child = ChildProcess(process_functions.add, 2, 3, pipes=2, forked=forked)
        assert child.connections[0].recv()["sum"] == 5
        child.end()
        if forked and sys.platform == "linux":
            server: int = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
            os.kill(server, signal.SIGKILL)


def wait_for_end(pid: int) -> None:
    until = time.monotonic() + 30.0
    while alive(pid):
        assert time.monotonic() < until, "it is still there"
        time.sleep(0.01)
