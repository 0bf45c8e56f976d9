"""The firmware's binary in the simulated rig: a campaign over the real drivers gives what the simulated rig gives."""

import sys
from pathlib import Path

import numpy as np
import pytest
from tests.rig.firmware.chip import build
from tests.rig.wires.process import over_wires

from dampyr import records
from dampyr.campaigns import perform
from dampyr.errors import InputError, RigFault
from dampyr.rig import RigSettings, simulated
from dampyr.rig.simulation.simulator import Simulator, parse_faults

pytestmark = [
    pytest.mark.prove,
    pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals of POSIX"),
]
CAMPAIGN = """
name = "both"
check_amplitude = 0.0
rest_between = "0.2 s"
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "1 Hz"
voltage = ["0 V", "1.98 V"]
cycles = 2
rest_before = "0.5 s"
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return build(tmp_path_factory.mktemp("firmware"))


def test_a_campaign_on_the_binary_is_that_on_the_simulated_rig(tmp_path: Path, built: tuple[Path, Path]) -> None:
    """Strokes within 2 %, and forces; over pyserial on a pseudo-terminal and nidaqmx on its gRPC server, and without wires."""
    (tmp_path / "both.toml").write_text(CAMPAIGN)
    elf, program = built
    folders = []
    for connect, how in (
        (over_wires, {"chip": (program, elf)}),
        (simulated, {"chip": (program, elf)}),
        (simulated, {}),
    ):
        with connect(**how) as rig:  # type: ignore[operator]
            assert rig.identity
            folders.append(perform(tmp_path / "both.toml", rig, tmp_path / f"{len(folders)}").folder)
    *ours, model = [list(records.read_campaign(folder)) for folder in folders]
    pairs = [pair for own in ours for pair in zip(own, model, strict=True)]
    assert len(pairs) == 4
    for one, other in pairs:
        assert np.ptp(one.displacement) == pytest.approx(np.ptp(other.displacement), rel=0.02)
        sizes = [np.ptp(np.quantile(each.force, [0.02, 0.98])) for each in (one, other)]
        assert sizes[0] == pytest.approx(sizes[1], rel=0.02)


def test_a_program_that_cannot_run_is_said_in_one_line(tmp_path: Path, built: tuple[Path, Path]) -> None:
    elf, program = built
    with pytest.raises(RigFault, match="the program that runs the firmware cannot be started"):
        simulated(chip=(tmp_path / "nothing", elf))
    (tmp_path / "other.elf").write_bytes(b"no binary")
    with pytest.raises(RigFault, match="is the binary one for the ATmega328P"):
        simulated(chip=(program, tmp_path / "other.elf"))


def test_faults_of_the_model_are_refused_with_the_binary(built: tuple[Path, Path]) -> None:
    elf, program = built
    with pytest.raises(InputError, match="only the firmware's model knows the fault stuck-encoder"):
        Simulator(RigSettings(), faults=parse_faults(["stuck-encoder@3s"]), chip=(program, elf))
