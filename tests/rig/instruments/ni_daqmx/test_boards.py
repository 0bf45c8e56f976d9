"""What a board lacks of what a rig asks of it, by stand-ins for NI's device, and the table of families in the docs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from tests.rig.table import settings
from tests.rig.wires import serial_wire
from tests.rig.wires.clock import Clock

from dampyr.rig import Rig, RigSettings
from dampyr.rig.diagnosis import RigCheck, _board_type, diagnose
from dampyr.rig.instruments.ni_daqmx.boards import FAMILIES, NOT_SUPPORTED, POSITION, family_of, lacks_of
from dampyr.rig.instruments.ni_daqmx.driver import NiBoard
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.simulator import Simulator

nidaqmx = pytest.importorskip("nidaqmx", reason="the extra rig is not installed: pip install dampyr[rig]")
daqmx_service = pytest.importorskip("tests.rig.wires.daqmx_service", reason="the extra rig is not installed")
PAGE = Path(__file__).parents[4] / "docs" / "reference" / "ni-boards.md"


def device(product: str = "PCI-6221", **changed: Any) -> Any:
    """A stand-in for a device with all that dampyr asks for."""
    whole: dict[str, Any] = {
        "product_type": product,
        "serial_num": 1,
        "ai_physical_chans": [f"Dev1/ai{k}" for k in range(16)],
        "ao_physical_chans": ["Dev1/ao0", "Dev1/ao1"],
        "ci_physical_chans": ["Dev1/ctr0", "Dev1/ctr1"],
        "do_lines": ["Dev1/port0/line0"],
        "terminals": [f"/Dev1/PFI{k}" for k in range(16)],
        "ci_meas_types": [SimpleNamespace(name="COUNT_EDGES"), SimpleNamespace(name=POSITION)],
        "ci_samp_clk_supported": True,
        "ao_samp_clk_supported": True,
        "ai_max_multi_chan_rate": 250e3,
    }
    return SimpleNamespace(**(whole | changed))


def test_the_board_that_dampyr_was_written_for_lacks_nothing() -> None:
    assert list(lacks_of(device(), settings(shunt="port0/line0"))) == []


@pytest.mark.parametrize(
    ("changed", "rig", "what", "needed"),
    [
        ({"ai_physical_chans": []}, RigSettings(), "analogue input ai0", True),
        ({"ci_physical_chans": ["Dev1/ctr1"]}, RigSettings(), "counter ctr0", True),
        ({"ci_physical_chans": ["Dev1/ctr0"]}, RigSettings(), "counter ctr1", True),
        ({"ci_meas_types": [SimpleNamespace(name="COUNT_EDGES")]}, RigSettings(), "a counter for an encoder", True),
        ({"ci_samp_clk_supported": False}, RigSettings(), "a sample clock for counters", True),
        ({"terminals": ["/Dev1/PFI0"]}, RigSettings(), "terminal PFI9", True),
        ({"ao_physical_chans": []}, RigSettings(), "analogue output ao0", True),
        ({"ao_samp_clk_supported": False}, RigSettings(), "a sample clock for the output", True),
        ({"do_lines": []}, settings(shunt="port0/line0"), "digital output port0/line0", False),
        ({"ai_max_multi_chan_rate": 500.0}, RigSettings(), "1000 samples/s of each of 1 inputs", True),
    ],
)
def test_each_thing_that_a_board_lacks_is_named_with_a_repair(
    changed: Any, rig: RigSettings, what: str, needed: bool
) -> None:
    (lack,) = lacks_of(device(**changed), rig)
    assert (lack.what, lack.needed) == (what, needed)
    assert lack.repair


def test_a_supply_of_its_own_needs_no_output() -> None:
    rig = replace(RigSettings(), wires=replace(RigSettings().wires, supply="scpi-supply"))
    assert list(lacks_of(device(ao_physical_chans=[], ao_samp_clk_supported=False), rig)) == []


def test_an_attribute_that_a_device_does_not_have_counts_as_a_lack() -> None:
    class Small:
        def __getattr__(self, name: str) -> Any:
            if name == "ao_samp_clk_supported":
                raise nidaqmx.errors.DaqError("not supported", NOT_SUPPORTED)
            return getattr(device(), name)

    assert [lack.what for lack in lacks_of(Small(), RigSettings())] == ["a sample clock for the output"]


def doctors_row(board: Any, rig: RigSettings | None = None) -> RigCheck:
    """What doctor says of the type of a board whose device is a stand-in."""
    settings = rig or RigSettings()
    connected = NiBoard(settings)
    connected._device = lambda: board  # type: ignore[method-assign]
    return _board_type(cast(Rig, SimpleNamespace(board=connected, settings=settings)))


def test_doctor_says_that_a_whole_board_lacks_nothing() -> None:
    assert doctors_row(device()) == RigCheck("board's type", "PCI-6221, lacks nothing that this rig asks for")


def test_doctor_says_in_one_row_what_a_board_lacks() -> None:
    row = doctors_row(device("USB-6001", ci_meas_types=[], ci_samp_clk_supported=False))
    assert row.observed == "USB-6001, lacks a counter for an encoder, a sample clock for counters"
    assert "take a board of the M or X Series" in str(row.repair)


def test_doctor_says_that_a_board_is_unknown() -> None:
    row = doctors_row(device("USB-6000"))
    assert row.observed.startswith("USB-6000 (not in the table of dampyr help ni-boards: unknown), lacks nothing")
    assert row.repair is None


def test_doctor_goes_on_where_a_board_cannot_be_asked() -> None:
    class Mute:
        def __getattr__(self, name: str) -> Any:
            raise nidaqmx.errors.DaqError("the attribute is not there", -200452)

    row = doctors_row(Mute())
    assert (row.what, row.observed) == ("board's type", "what it has could not be asked")
    assert "the board Dev1 gives an error" in str(row.repair)


def test_doctor_asks_a_board_over_the_wire(tmp_path: Path) -> None:
    clock = Clock(Simulator(RigSettings()), EventFile(None), real_time=True)
    wires = serial_wire.serve(clock) | daqmx_service.serve(clock)
    clock.start()
    path = tmp_path / "rig.toml"
    path.write_text("[wires]\n" + "".join(f'{name} = "{value}"\n' for name, value in wires.items()))
    rows = [check for check in diagnose(path) if check.what in ("board's type", "load cell now")]
    assert rows[0] == RigCheck("board's type", "PCI-6221, lacks nothing that this rig asks for")
    assert rows[1].observed.endswith("N rms")
    clock.finished.set()
    clock.thread.join()
    for end in clock.on_end:
        end()


def test_a_board_without_a_documented_shared_clock_is_told() -> None:
    (lack,) = lacks_of(device("USB-6212"), RigSettings())
    assert "clock to its output" in lack.what
    assert not lack.needed


def test_the_page_has_the_families_of_the_source_with_their_documents() -> None:
    text = " ".join(PAGE.read_text().split())
    for family in FAMILIES:
        assert family.name in text
        assert family.sources
        for source in family.sources:
            assert source in text
    assert (family_of("USB-6211") or FAMILIES[0]).name.startswith("USB-621x")
    assert (family_of("USB-6009") or FAMILIES[0]).name.startswith("USB-6008")
    assert family_of("NI 9205") is None
