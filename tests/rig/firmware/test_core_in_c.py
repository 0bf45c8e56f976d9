"""The firmware's core in C: register by register as its model, and whatever bytes come."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.rig.firmware.native_core import SOURCES, Native, compiled

from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import VERSION, Reader, Reply, Request, SerialFrame, State, encode
from dampyr.rig.firmware.twin import Twin

pytestmark = [
    pytest.mark.prove,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc was found; `make compiler` installs Debian's"),
]
SANITIZED = ["-std=gnu99", "-O1", "-g", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined"]


@pytest.fixture(scope="module")
def fuzz(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = tmp_path_factory.mktemp("fuzz") / "fuzz_core"
    files = [Path(__file__).with_name("fuzz_core.c"), SOURCES / "core.c", SOURCES / "frames.c"]
    subprocess.run(
        ["gcc", *SANITIZED, "-fno-sanitize-recover=all", f"-I{SOURCES}", *map(str, files), "-o", str(program)],
        check=True,
    )
    return program


@pytest.mark.parametrize(("kind", "count"), [("mutated", 1_000_000), ("valid", 300_000)])
def test_no_bytes_harm_it(fuzz: Path, kind: str, count: int) -> None:
    """A million frames that were changed on the way arm nothing; requests of all kinds move nothing beyond its limits."""
    ended = subprocess.run([str(fuzz), kind, str(count), "7"], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert int(ended.stdout) > 10000  # it was awake


LIKELY = {
    State.FAULT: (Request.CLEAR, Request.HELLO),
    State.IDLE: (Request.LIMITS, Request.HOME, Request.HEARTBEAT, Request.ARM, Request.ARM),
    State.ARMED: (
        Request.SETPOINTS, Request.SETPOINTS, Request.FOLLOW, Request.FOLLOW, Request.REVERSE, Request.JOG, Request.HOME,
        Request.HEARTBEAT, Request.HEARTBEAT,
    ),
    State.FOLLOWING: (Request.HEARTBEAT, Request.SETPOINTS),
}  # fmt: skip
"""What leads on from a state."""


def requests(rng: np.random.Generator, twin: Twin) -> SerialFrame:
    """One that is often carried out in this state."""
    position, following = int(twin.registers[c.R_POSITION]), int(twin.registers[c.R_NEXT])
    likely = LIKELY.get(twin.state, (Request.HEARTBEAT,)) if rng.random() < 0.8 else tuple(Request)
    kind = Request(int(rng.choice([int(each) for each in likely])))
    n = int(rng.integers(1, 17))
    high = int(rng.choice([7000, 300, 40000]))
    values: dict[Request, tuple[int, ...]] = {
        Request.HELLO: (VERSION if rng.random() < 0.95 else 2,),
        Request.LIMITS: (
            -high, high, int(rng.choice([24000, 900])), 200, int(rng.choice([255, 90])), 300, int(rng.integers(4)),
            int(rng.choice([255, 255, 20, 1])), int(rng.choice([0, 0, 500])),
        ),
        Request.HOME: (int(rng.integers(3)), int(rng.integers(-300, 300))),
        Request.JOG: (int(rng.integers(-700, 700)), int(rng.integers(1, 500))),
        Request.SETPOINTS: (int(rng.choice([0, following, following, following + 1])), *(
            int(p) for p in np.clip(position + np.cumsum(rng.integers(-30, 31, n)), -37000, 37000)
        )),
        Request.FOLLOW: (int(rng.integers(1, 60)), following + int(rng.integers(0, 20))),
        Request.REVERSE: (int(rng.integers(1, 260)) % 256, int(rng.integers(10, 600)), int(rng.integers(0, 200)), 3),
    }  # fmt: skip
    return SerialFrame(kind, int(rng.integers(256)), values.get(kind, ()))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> object:
    return compiled(tmp_path_factory.mktemp("core"))


def shown(registers: NDArray[np.int64]) -> NDArray[np.int64]:
    """The registers, where two are cut off from where on more makes no difference; the C holds them in fewer bits."""
    cut = registers.copy()
    cut[c.R_SINCE] = min(cut[c.R_SINCE], 65535)
    cut[c.R_FREE] = min(cut[c.R_FREE], c.FREE_TRAVEL * c.RATE + 1)
    return cut


@pytest.mark.parametrize("seed", range(3))
def test_every_register_is_that_of_the_model(library: object, seed: int) -> None:
    """Random dialogues on a table that moves as the model's motor is driven, with the index, open inputs and lost edges."""
    rng = np.random.default_rng(seed)
    twin, core, reader = Twin(), Native(library), Reader()  # type: ignore[arg-type]
    place = motor = 0.0
    states, faults = set(), 0
    for number in range(1500):
        frame = requests(rng, twin)
        reply = twin.receive(encode(frame))
        assert core.receive(encode(frame)) == reply, (number, frame)
        (answer,) = reader.feed(reply)
        assert isinstance(answer.kind, Reply)
        swapped = rng.random() < 0.02
        for _ in range(int(rng.integers(1, 80))):
            duty = int(twin.registers[c.R_DUTY])
            wanted = 65.0 * max(0, abs(duty) - 15) * (1 if (duty > 0) is not swapped else -1)
            motor += (wanted - motor) / 24.0
            old, place = place, float(np.clip(place + motor / 1000.0, -9000.0, 9000.0))
            mark = 120
            latched = min(int(old), int(place)) < mark <= max(int(old), int(place))
            given = (
                int(place), latched, mark + (3 if rng.random() < 0.05 else 0), rng.random() < 2e-4,
                int(rng.integers(8)) if rng.random() < 1e-3 else 0, 600 if duty > 200 else 100,
            )  # fmt: skip
            twin.tick(*given)
            core.tick(*given)
            states.add(twin.state)
            faults |= int(twin.faults)
            same = shown(core.registers) == shown(twin.registers)
            assert same.all(), (number, np.flatnonzero(~same), core.registers[~same], twin.registers[~same])
    assert states == set(State)
    assert faults.bit_count() >= 8
