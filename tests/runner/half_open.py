"""A TCP proxy whose links go silent at both ends: as when the other host has lost its power."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress


class HalfOpen:
    """Passes bytes on to ``port``, until `freeze`: links of before then stay open and say nothing.

    Attributes:
        port: of this proxy.
    """

    def __init__(self, port: int) -> None:
        self._target = port
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listening.getsockname()[1]
        self._frozen: list[threading.Event] = [threading.Event()]
        self._ends: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def freeze(self) -> None:
        """Nothing passes any more over the links there are; new ones are made."""
        self._frozen[-1].set()
        self._frozen.append(threading.Event())

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._listening.accept()
                far = socket.create_connection(("127.0.0.1", self._target))
                self._ends += [near, far]
                for ends in ((near, far), (far, near)):
                    pump = threading.Thread(
                        target=_pass_on, args=(*ends, self._frozen[-1]), daemon=True
                    )
                    pump.start()

    def close(self) -> None:
        """End it and every link."""
        self._listening.close()
        for end in self._ends:
            end.close()


def _pass_on(source: socket.socket, target: socket.socket, frozen: threading.Event) -> None:
    with suppress(OSError):
        while data := source.recv(65536):
            if not frozen.is_set():
                target.sendall(data)
        if not frozen.is_set():
            target.shutdown(socket.SHUT_WR)
