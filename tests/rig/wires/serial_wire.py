"""The Uno's serial wire of a simulated rig: a TCP port or a pseudo-terminal."""

from __future__ import annotations

import os
import socket
import time
from threading import Thread

from tests.rig.wires.clock import Clock

NOBODY = 0.01  # s between two looks whether somebody has opened the terminal


class Serial:
    """The Uno's serial wire as a TCP port for one client at a time; others are refused."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.busy = clock, False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        Thread(target=self._accept, name="serial", daemon=True).start()

    def _accept(self) -> None:
        while True:
            client, _ = self.listener.accept()
            if self.busy:
                client.close()
                continue
            self.busy = True
            self.clock.client_connected()
            Thread(target=self._serve, args=(client,), name="client", daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            while data := client.recv(4096):
                with self.clock.locked() as rig:
                    reply = rig.serial(data)
                client.sendall(reply)
        except OSError:
            pass  # a killed client resets the connection: it has disconnected, as below
        finally:
            self.busy = False
            self.clock.client_disconnected()
            client.close()


class Terminal:
    """The Uno's serial wire as a pseudo-terminal, which pyserial opens as it does a port; of POSIX systems."""

    def __init__(self, clock: Clock) -> None:
        import tty

        self.clock = clock
        self.master, host = os.openpty()
        tty.setraw(host)
        self.name = os.ttyname(host)
        os.close(host)
        Thread(target=self._serve, name="terminal", daemon=True).start()

    def _serve(self) -> None:
        connected = False
        while True:
            try:
                data = os.read(self.master, 4096)
            except OSError:  # nobody has it open
                if connected:
                    self.clock.client_disconnected()
                connected = False
                time.sleep(NOBODY)
                continue
            if not connected:
                self.clock.client_connected()
                connected = True
            with self.clock.locked() as rig:
                reply = rig.serial(data)
            os.write(self.master, reply)


def serve(clock: Clock) -> dict[str, str]:
    """Serve the serial wire, on the loopback or as a pseudo-terminal; the wire to it."""
    if clock.terminal:
        return {"serial": Terminal(clock).name}
    return {"serial": f"socket://127.0.0.1:{Serial(clock).port}"}
