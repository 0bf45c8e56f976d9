"""The damper that OpenSees talks to: in chapter 5's building under El Centro, and message by message."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from functools import partial
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from tests.export.opensees_process import FIRST_FLOOR, model
from tests.invariants.test_every_part import typical

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.export import opensees_server
from dampyr.export.opensees_server import live_damper
from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper
from dampyr.structures.control_laws import law_of
from dampyr.structures.controller import ControllerRun, design_controller
from dampyr.structures.law_input import LawInput
from dampyr.structures.wanted_force import inverse_of
from dampyr.studies import raminelli_2020


def begin_of_el_centro(seconds: float) -> GroundMotion:
    motion = dp.ground_motions.el_centro()
    return GroundMotion(motion.acceleration[: round(seconds / motion.dt) + 1], motion.dt, "begin of El Centro")


@contextmanager
def answered(make: Any) -> Iterator[tuple[int, Future[opensees_server.LiveSummary]]]:
    """The server in a thread of this process: its port, and what it says of the only client."""
    listening = opensees_server.listen("127.0.0.1", 0)

    def serve() -> opensees_server.LiveSummary:
        connection, _ = listening.accept()
        with connection:
            return opensees_server.answer(connection, make)

    with closing(listening), ThreadPoolExecutor(1) as thread:
        yield listening.getsockname()[1], thread.submit(serve)


@contextmanager
def served(*options: str) -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """``dampyr serve raminelli_2020`` in a process of its own, and its port."""
    words = [sys.executable, "-m", "dampyr", "serve", "raminelli_2020", "--opensees", "0", *options]
    server = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        stream = server.stderr if "--json" in options else server.stdout
        assert stream is not None
        match = re.search(r"listening on 127\.0\.0\.1 port (\d+)", stream.readline())
        assert match
        yield int(match[1]), server
    finally:
        server.kill()
        server.communicate()


@pytest.mark.usefixtures("opensees")
@pytest.mark.prove
@pytest.mark.parametrize("nodes", [[1], [0, 1]], ids=["on the ground", "between two nodes"])
def test_the_live_damper_gives_chapter_5(nodes: list[int]) -> None:
    """Within 0.1 % with steps of 5 ms, in three iterations a step."""
    with served("--voltage", "0") as (port, server):
        answer = model(0.005, port=port, nodes=nodes)
        said, _ = server.communicate(timeout=20)
    assert 1e3 * answer["peaks"][0] == pytest.approx(FIRST_FLOOR, rel=1e-3)
    assert answer["iterations"] < 3.0
    assert "the client ended it: 6236 steps to 31.18 s" in said
    assert "largest stroke 27.2" in said


@pytest.mark.by_hand  # the step of 5 ms, above, is the proof that is always run
@pytest.mark.usefixtures("opensees")
def test_smaller_steps_come_closer() -> None:
    """1 ms: 27.2080 mm, within 0.01 %."""
    with served("--voltage", "0") as (port, _):
        answer = model(0.001, port=port, nodes=[1])
    assert 1e3 * answer["peaks"][0] == pytest.approx(FIRST_FLOOR, rel=1e-4)


@pytest.mark.prove
@pytest.mark.usefixtures("opensees")
@pytest.mark.parametrize("law", ["lyapunov", pytest.param("clipped_optimal:lag=10ms", marks=pytest.mark.by_hand)])
def test_a_control_law_live_is_that_of_dampyr(law: str) -> None:
    """Within 1 %, with the displacements and velocities of all floors; steps of 1 ms, in the 8 s with the largest peaks."""
    damper, motion = raminelli_2020.damper(), begin_of_el_centro(8.0)
    with served("--control", law) as (port, _):
        answer = model(0.001, motion, port=port, nodes=[1, 2])
    expected = dp.structures.respond(dp.structures.two_storey(), motion, {1: damper}, voltage=law_of(law, damper))
    print(1e3 * expected.peak_displacement)
    np.testing.assert_allclose(answer["peaks"], expected.peak_displacement, rtol=1e-2)


@pytest.mark.parametrize("name", dp.structures.available_control_laws())
def test_a_law_decides_on_what_is_committed_as_the_controller_does(name: str) -> None:
    """One record of states and forces, in steps of a fifth of the period; between its samples nothing is decided."""
    damper, building, rng = raminelli_2020.damper(), dp.structures.two_storey(), np.random.default_rng(3)
    law, motion = dp.structures.control_law(name, high=3.0), begin_of_el_centro(1.0)
    row = building.connection(1)
    here = LawInput(law, damper, building, row, motion)
    run = ControllerRun(design_controller(law, building, row[None], 0), inverse=inverse_of(law, damper))
    velocity = np.concatenate(
        [[0.0], np.cumsum(0.5 * motion.dt * (motion.acceleration[1:] + motion.acceleration[:-1]))]
    )
    for k in range(100):
        t = 0.001 * k
        q, v, f = 1e-4 * rng.standard_normal(2), 0.02 * rng.standard_normal(2), 200.0 * rng.standard_normal()
        here.decide_at(t, q, v, f)
        if k % 5 == 0:
            ground = [float(np.interp(t, motion.time, of)) for of in (velocity, motion.acceleration)]
            expected = run.decide(np.concatenate([q, v, ground, [f]]))
        assert here.command == expected


class Client:
    """The element's end of the wire, for what OpenSees would not send."""

    def __init__(self, port: int, degrees: int = 1, size: int = 256) -> None:
        self.socket, self.size = socket.create_connection(("127.0.0.1", port), timeout=60), size
        header = [degrees, degrees, degrees, 0, 1, 0, 0, 0, degrees, 0, size]
        self.socket.sendall(np.array(header, dtype="<i4").tobytes())

    def close(self) -> None:
        self.socket.close()

    def send(self, *numbers: float) -> None:
        self.socket.sendall(np.pad(np.array(numbers, dtype="<f8"), (0, self.size - len(numbers))).tobytes())

    def ask(self, what: int) -> np.ndarray:
        self.send(what)
        data = b""
        while len(data) < 8 * self.size:
            part = self.socket.recv(8 * self.size - len(data))
            assert part, "the server has left"
            data += part
        return np.frombuffer(data, dtype="<f8")


def test_the_wire_step_by_step() -> None:
    """Forces of the committed path are those of `Damper.force`, whatever was tried between; the tangent is the step's."""
    damper = raminelli_2020.damper()
    t = 0.005 * np.arange(60)
    x, v = 0.006 * np.sin(9.0 * t), 0.054 * np.cos(9.0 * t)
    expected = damper.force(t, x, velocity=v, voltage=1.98)
    _, kw, rho = damper.values(1.98)
    initial = kw * rho
    with answered(partial(live_damper, damper=damper, u=1.98)) as (port, said), closing(Client(port)) as client:
        for k in range(t.size):
            for wrong in (2.0, -1.0):
                client.send(3, wrong * x[k] + 1e-3, -v[k], 0.0, t[k])
            client.send(3, x[k], v[k], 0.0, t[k])
            force, c, stiffness = (float(client.ask(what)[0]) for what in (10, 14, 13))
            assert force + c * v[k] == pytest.approx(expected[k], rel=1e-9, abs=1e-6)
            if k:
                h = 1e-8
                client.send(3, x[k] + h, v[k], 0.0, t[k])
                moved = float(client.ask(10)[0])
                assert (moved - force) / h == pytest.approx(stiffness, rel=2e-2, abs=5.0)
                client.send(3, x[k], v[k], 0.0, t[k])
            assert float(client.ask(15)[0]) == 0.0
            assert float(client.ask(12)[0]) == pytest.approx(initial, rel=1e-3)
            client.send(5)
        client.send(99)
        summary = said.result(timeout=60)
    assert (summary.steps, summary.degrees_of_freedom) == (60, 1)
    assert summary.ended == "the client ended it"
    assert summary.time == pytest.approx(t[-1])


def test_what_is_wrong_on_the_wire_is_a_sentence() -> None:
    fixed = partial(live_damper, damper=raminelli_2020.damper(), u=0.0)
    law = law_of("lyapunov", raminelli_2020.damper())
    controlled = partial(
        live_damper, damper=raminelli_2020.damper(), u=law, law=law, building=dp.structures.two_storey()
    )
    for make, degrees, words in (
        (fixed, 3, "3 degrees of freedom; give it one"),
        (fixed, 0, "is not a genericClient of OpenSees"),
        (controlled, 1, "1 degrees of freedom and"),
    ):
        with (
            answered(make) as (port, said),
            closing(Client(port, degrees=degrees)),
            pytest.raises(InputError, match=words),
        ):
            said.result(timeout=60)
    with answered(fixed) as (port, said):
        client = Client(port)
        client.send(3, 0.0, 0.0, 0.0, 0.0)
        client.close()
        assert said.result(timeout=60).ended == "the client left without a word"
        assert said.result().steps == 0
    with answered(fixed) as (port, said), closing(Client(port)) as client:
        client.send(77)
        with pytest.raises(InputError, match="the client sent 77"):
            said.result(timeout=60)
    with answered(fixed) as (port, said):
        socket.create_connection(("127.0.0.1", port)).close()
        assert said.result(timeout=60).ended == "the client left before it said anything"


@pytest.mark.prove
def test_what_is_wrong_on_the_wire_ends_the_command_with_that_sentence() -> None:
    with served("--voltage", "0") as (port, server), closing(Client(port, degrees=3)):
        assert "3 degrees of freedom; give it one" in "".join(server.communicate(timeout=60))
    with served("--voltage", "0") as (port, server):
        client = Client(port)
        client.send(3, 0.0, 0.0, 0.0, 0.0)
        client.close()
        assert "the client left without a word: 0 steps" in "".join(server.communicate(timeout=60))
    with served("--voltage", "0") as (port, server), closing(Client(port)) as client:
        client.send(77)
        assert "the client sent 77" in "".join(server.communicate(timeout=60))
    with served("--voltage", "0", "--json") as (port, server), closing(Client(port)) as client:
        client.send(3, 0.0, 0.0, 0.0, 0.0)
        client.send(5)
        client.send(99)
        said = json.loads(server.communicate(timeout=60)[0])
    assert (said["steps"], said["degrees_of_freedom"], said["ended"]) == (1, 1, "the client ended it")


def test_wrong_arguments_are_refused_before_anything_listens() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen(1)
        for options, words in (
            (["--opensees", str(taken.getsockname()[1]), "--voltage", "0"], "cannot be had"),
            (["--opensees", "70000", "--voltage", "0"], "port = 70000 is not allowed"),
            (["--opensees", "0", "--voltage", "9"], "calibrated"),
            (["--opensees", "0"], "takes a voltage"),
            (["--opensees", "0", "--voltage", "0", "--control", "lyapunov"], "give one of --control"),
            (["--opensees", "0", "--control", "on_off"], "needs the motion of the ground"),
            (["--opensees", "0", "--voltage", "0", "--storey", "1"], "give --structure too"),
            (["--opensees", "0", "--control", "lyapunov", "--storey", "5"], "5"),
        ):
            done = CliRunner().invoke(cli, ["serve", "raminelli_2020", *options])
            assert (done.exit_code, words in done.stderr) == (2, True), (options, done.stderr)


def test_a_delay_is_refused() -> None:
    with pytest.raises(InputError, match="the part delay is of the rig"):
        opensees_server.check_live(Damper("dahl + delay", typical("dahl + delay")))
