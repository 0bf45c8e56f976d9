"""The firmware's C, compiled for this computer, with the registers of its model in Python."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

import dampyr.rig.firmware
from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import Reader, SerialFrame, encode
from dampyr.rig.firmware.twin import Twin, source_digest

SOURCES = Path(dampyr.rig.firmware.__file__).parent / "uno"
OTHERWISE = {"free_travel": c.R_FREE, "turn_at": c.R_TURN, "end_seen": c.R_ENDS}
STRICT = ("-std=gnu99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O1")


def compiled(folder: Path, *options: str) -> ctypes.CDLL:
    """The library; `options` for the compiler come last."""
    library = folder / "core.so"
    own = Path(__file__).with_name("native.c")
    digest = f"-DDIGEST=0x{source_digest():08x}UL"
    files = [str(own), *(str(SOURCES / name) for name in ("core.c", "frames.c"))]
    subprocess.run(
        ["gcc", *STRICT, "-shared", "-fPIC", f"-I{SOURCES}", digest, *files, "-o", str(library), *options], check=True
    )
    loaded = ctypes.CDLL(str(library))
    loaded.field.restype = ctypes.c_char_p
    loaded.make.restype = ctypes.c_void_p
    loaded.bad_frames.restype = ctypes.c_uint16
    loaded.greeted.restype = ctypes.c_bool
    for name, types in {
        "store": [ctypes.c_void_p, ctypes.c_void_p],
        "load": [ctypes.c_void_p, ctypes.c_void_p],
        "restart": [ctypes.c_void_p, ctypes.c_int32],
        "feed": [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_int],
        "bad_frames": [ctypes.c_void_p],
        "greeted": [ctypes.c_void_p],
        "set_bad_frames": [ctypes.c_void_p, ctypes.c_uint16],
        "tick": [
            ctypes.c_void_p,
            ctypes.c_int32,
            ctypes.c_bool,
            ctypes.c_int32,
            ctypes.c_bool,
            ctypes.c_uint8,
            ctypes.c_uint16,
        ],
    }.items():
        getattr(loaded, name).argtypes = types
    return loaded


class Native(Twin):
    """What the model offers, done by the C; its registers are those of the C after every call."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self._library, self._core = library, library.make(0)
        names = []
        while (name := library.field(len(names))) is not None:
            names.append(name.decode())
        self._places = [OTHERWISE.get(name, getattr(c, f"R_{name.upper()}", -1)) for name in names[:-1]]
        assert names[-1] == "slot"
        assert -1 not in self._places
        self._row = np.zeros(len(names) + c.QUEUE + c.WINDOW, np.int64)
        self._n = len(names) - 1
        self.registers = np.zeros(c.REGISTERS, np.int64)
        self.reader = Reader()
        self._out = ctypes.create_string_buffer(1 << 16)
        self._store()

    def restart(self) -> None:
        """As after power-on."""
        self._library.restart(self._core, int(self.registers[c.R_COUNTS]))
        self._store()

    def receive(self, data: bytes) -> bytes:
        """Bytes of the host, and the replies."""
        self._load()
        size = self._library.feed(self._core, data, len(data), self._out, len(self._out))
        assert size >= 0
        self._store()
        return self._out.raw[:size]

    def answer(self, frame: SerialFrame) -> bytes:
        """The reply to a frame."""
        return self.receive(encode(frame))

    def tick(self, *given: Any) -> None:
        """A millisecond."""
        counts, latched, index, glitch, inputs, *current = given
        self._load()
        index = index if latched else 0  # else of no account, and beyond 32 bits in some tests
        self._library.tick(self._core, counts, bool(latched), index, bool(glitch), inputs, *(current or [0]))
        self._store()

    def _store(self) -> None:
        self._library.store(self._core, self._row.ctypes.data)
        self.registers[self._places] = self._row[: self._n]
        self.registers[c.R_QUEUE :] = self._row[self._n + 1 :]
        self.reader.bad = self._library.bad_frames(self._core)
        self.handshake_done = self._library.greeted(self._core)

    def _load(self) -> None:
        self._row[: self._n] = self.registers[self._places]
        self._row[self._n] = self.registers[c.R_TIME] % c.WINDOW
        self._row[self._n + 1 :] = self.registers[c.R_QUEUE :]
        self._library.load(self._core, self._row.ctypes.data)
        self._library.set_bad_frames(self._core, self.reader.bad & 0xFFFF)
