"""Boards of National Instruments: what dampyr needs of one, what families are documented to have, what a connected one lacks.

The table is from public documents of NI's, each with its place; None where these were not found to say it. What is connected
is asked itself, through nidaqmx's attributes of the device: the table only says what to expect before a board is bought.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from dampyr.rig.instruments.catalogue import OUTPUT
from dampyr.rig.settings import RigSettings

NOT_SUPPORTED = -200197  # NI-DAQmx's number of an attribute that a device does not have
POSITION = "POSITION_LINEAR_ENCODER"  # nidaqmx.constants.UsageTypeCI, by name: nidaqmx may not be installed


@dataclass(frozen=True)
class BoardFamily:
    """A family of boards, as NI documents it; None: not found."""

    name: str
    counters: int | None
    """Counters that read the encoder's lines A and B by themselves, at the same time."""
    timed_output: bool | None
    """Whether its analogue output has a sample clock."""
    shared_clock: bool | None
    """Whether the inputs' sample clock is named among the sources of the output's; counters take it in each family that has
    a clocked encoder reading."""
    filters: str | None
    """Widths of the filters on counter inputs."""
    digital_outputs: str | None
    remark: str
    sources: tuple[str, ...]


FAMILIES = (
    BoardFamily(
        "PCI-6221 (M Series, a PCI card)", 2, True, None, "125 ns, 6.425 us, 2.55 ms", "port0, port1 and port2",
        "what dampyr was written for; the machine needs a PCI slot. The manuals' list of the output's clocks names PFI, "
        "RTSI and the "
        "card's own; routes through RTSI are made by NI-DAQmx",
        ("M Series User Manual 371022, p. 7-32 and 9-6", "documentation.help, M Series Physical Channels"),
    ),
    BoardFamily(
        "USB-621x (bus-powered M Series)", 2, True, False, "125 ns, 6.425 us, 2.56 ms", "port1, 4 or 8 lines",
        "most members have two outputs: ask the board. The output's clocks are listed as its own time base, a counter's "
        "output or an "
        "input PFI, and no RTSI was found: wire the inputs' sample clock from an output PFI to an input PFI, which "
        "dampyr's driver "
        "does not ask for yet. Inputs are PFI0 to PFI3 on 6210, 6211 and 6215: name one of these in wires.index, not PFI9",
        ("NI USB-621x User Manual 371931, p. 4-15, 5-1, 5-8, 8-15, 8-18, 8-35, 9-27",
         "documentation.help, Bus-Powered M Series Physical Channels"),
    ),
    BoardFamily(
        "USB-6001, -6002, -6003", 0, True, None, None, None,
        "one counter that counts edges of one line, upward only: no encoder",
        ("NI USB-6001/6002/6003 User Guide, p. 18 and 19",
         "forums.ni.com, Interfacing Quadrature Encoder to USB-6001/2/3 (3948499)"),
    ),
    BoardFamily(
        "USB-6008, -6009", 0, None, None, None, "12 lines, set by software",
        "one counter that counts falling edges: no encoder",
        ("NI USB-6008/6009 User Guide and Specifications, p. 16 and 24",),
    ),
    BoardFamily(
        "PCIe-63xx (X Series)", 4, True, True, "90 ns, 5.12 us, 2.56 ms, or a width of one's own", "port0, port1 and port2",
        "set board.encoder_filter to 5.12 us: 6.425 us was not found among its fixed widths. Not every member has "
        "outputs: ask the board",
        ("X Series User Manual, p. 5-5 and 5-9", "ni.com/docs, ni-daqmx, Digital filtering (digfiltxseries)",
         "ni.com/docs, ni-daqmx, X Series Physical Channels (xseriesphychannels)",
         "labscript-devices, models/capabilities.json, as NI-DAQmx said of a PCIe-6343 and a -6363: 4 counters, 4 outputs"),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Lack:
    """Something that the rig's settings ask for and the board does not have; ``needed``: nothing can be recorded without."""

    what: str
    repair: str
    needed: bool


def lacks_of(device: Any, rig: RigSettings) -> Iterator[Lack]:
    """What ``device``, a `nidaqmx.system.Device`, lacks of what ``rig`` asks of it.

    An attribute that the driver does not support on this device is taken for a lack of what it describes.
    """
    wires = rig.wires
    inputs, outputs = (_names(device, f"{kind}_physical_chans") for kind in ("ai", "ao"))
    counters, lines = _names(device, "ci_physical_chans"), _names(device, "do_lines")
    terminals = {terminal.rpartition("/")[2].lower() for terminal in _asked(device, "terminals", ())}
    for role, name in rig.inputs.items():
        if name.lower() not in inputs:
            yield Lack(f"analogue input {name}", f"name another one of its {len(inputs)} in wires.{role}", True)
    for role, counter in (("position", wires.position), ("index", wires.index.partition("/")[0])):
        if counter and counter.lower() not in counters:
            here = f"its counters are {', '.join(sorted(counters)) or 'none'}"
            other = (
                f"name another one in wires.{role}"
                if role == "position"
                else "leave wires.index empty: the index is then not checked by the board"
            )
            yield Lack(f"counter {counter}", f"{here}; {other}", True)
    mark = wires.index.partition("/")[2].lower()
    if mark and mark not in terminals:
        yield Lack(
            f"terminal {wires.index.partition('/')[2]}",
            "wire the encoder's Z to another PFI input, and name it in wires.index",
            True,
        )
    if wires.supply == OUTPUT and wires.command.lower() not in outputs:
        other = "name another one in wires.command, or a supply of its own in wires.supply"
        yield Lack(f"analogue output {wires.command}", other, True)
    if wires.shunt and wires.shunt.lower() not in lines:
        other = "name another line in wires.shunt, or leave it empty: the cell's gain is then not checked"
        yield Lack(f"digital output {wires.shunt}", other, False)
    yield from _missing_clocks(device, rig)


def _missing_clocks(device: Any, rig: RigSettings) -> Iterator[Lack]:
    """What of the channels cannot be read or written on one clock as fast as the rig asks."""
    wires, product = rig.wires, device.product_type
    if _names(device, "ci_physical_chans"):
        kinds = {getattr(kind, "name", str(kind)) for kind in _asked(device, "ci_meas_types", ())}
        if POSITION not in kinds:
            yield Lack(
                "a counter for an encoder", f"the {product} counts edges only; take a board of the M or X Series", True
            )
        if not _asked(device, "ci_samp_clk_supported", False):
            yield Lack(
                "a sample clock for counters",
                "positions and forces would not belong together; take an M or X Series board",
                True,
            )
    outputs = _names(device, "ao_physical_chans")
    if wires.supply == OUTPUT and outputs:
        if not _asked(device, "ao_samp_clk_supported", False):
            other = "the coil's voltage would not be on the samples' clock; name a supply of its own in wires.supply"
            yield Lack("a sample clock for the output", other, True)
        elif (family := family_of(product)) is not None and family.shared_clock is False:
            yield Lack("a documented way of its inputs' clock to its output", family.remark, False)
    fastest, channels = float(_asked(device, "ai_max_multi_chan_rate", 0.0)), len(rig.inputs)
    if _names(device, "ai_physical_chans") and rig.board.rate * channels > fastest:
        other = f"it takes {fastest:g} a second in all; lower board.rate to {fastest / channels:g} Hz"
        yield Lack(f"{rig.board.rate:g} samples/s of each of {channels} inputs", other, True)


def family_of(product: str) -> BoardFamily | None:
    """The family of a product such as "USB-6211"; None where the table has none."""
    names = ("PCI-6221",), ("USB-621",), ("USB-6001", "USB-6002", "USB-6003"), ("USB-6008", "USB-6009"), ("PCIe-63",)
    return next((family for starts, family in zip(names, FAMILIES, strict=True) if product.startswith(starts)), None)


def _asked(device: Any, name: str, without: Any) -> Any:
    """An attribute of the device; ``without`` where NI-DAQmx does not support that attribute on it."""
    from nidaqmx.errors import DaqError

    try:
        return getattr(device, name)
    except DaqError as problem:
        if problem.error_code != NOT_SUPPORTED:
            raise
        return without


def _names(device: Any, name: str) -> set[str]:
    """The channels of a kind, without the device's name."""
    return {str(getattr(channel, "name", channel)).partition("/")[2].lower() for channel in _asked(device, name, ())}
