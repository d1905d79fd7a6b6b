"""A connection to an RLDX or GR00T server: ZeroMQ request and reply, one at a time.

A socket on which something went wrong is closed, so that an answer that comes late has nowhere
to come to.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping
from contextlib import suppress

import zmq

from fairlead.errors import PolicyError
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policies.remote.rldx_wire import Arrays, decode, encode
from fairlead_skill_runner.policies.remote.served_policy import (
    NO_MESSAGE,
    SIGN_OF_LIFE_S,
    RemoteOptions,
    busy_server,
    no_server,
    refused_key,
    server_failed,
)

WHO = "rldx policy"
_MESSAGE_MAX_BYTES = 64 * 2**20
_UNKNOWN, _NO_ACCESS = "Unknown endpoint", "Unauthorized"
"""How the servers begin to say that they have no such endpoint, or want another key."""


class ServerError(PolicyError):
    """The server answered with an error."""

    def __init__(self, options: RemoteOptions, said: str) -> None:
        refused = refused_key(WHO, options, said) if said.startswith(_NO_ACCESS) else None
        super().__init__(str(refused or server_failed(WHO, options.address, said)))
        self.said = said


class ZmqLink:
    """One socket at a time.

    Attributes:
        arrays: how arrays are written in requests.
    """

    def __init__(self, skill: SkillManifest, options: RemoteOptions) -> None:
        self._skill, self._options = skill, options
        self._socket: zmq.Socket[bytes] | None = None
        self._monitor: zmq.Socket[bytes] | None = None
        self._key: str | None = None
        self.arrays: Arrays = "npy"

    def dial(self) -> bool:
        """A new socket, on which the server answers; whether it is the one of the socket before.

        A host that loses its power ends no connection, so the old one is asked.

        Raises:
            PolicyError: if no server is there, it is busy, or wants another key.
        """
        is_the_same = self._is_the_same()
        self.close()
        self._open()
        return is_the_same

    def _is_the_same(self) -> bool:
        if self._socket is None:
            return False
        with suppress(TimeoutError, PolicyError):
            self.call({"endpoint": "ping"}, SIGN_OF_LIFE_S)
            return True
        return False

    def _open(self) -> None:
        self._key = self._options.api_key(WHO)
        self._socket = zmq.Context.instance().socket(zmq.REQ)
        self._monitor = self._socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.IPV6, 1)  # besides IPv4
        self._socket.setsockopt(zmq.MAXMSGSIZE, _MESSAGE_MAX_BYTES)  # a larger one ends the link
        try:
            self._socket.connect(self._options.address)
        except zmq.ZMQError as error:
            self.close()
            raise no_server(WHO, self._skill, self._options, error) from None
        try:
            self.call({"endpoint": "ping"}, self._options.connect_timeout_s)
        except TimeoutError as error:
            if _listens(self._options.address):
                raise busy_server(WHO, self._skill, self._options, "no answer to a ping") from None
            raise no_server(WHO, self._skill, self._options, error) from None

    def ask(self, endpoint: str, data: Mapping[str, object] | None = None) -> object:
        """The answer of an endpoint that takes no time; None if the server has none of that name.

        Raises:
            PolicyError: for no answer, or an error.
        """
        request: dict[str, object] = {"endpoint": endpoint}
        if data is not None:
            request["data"] = data
        try:
            return self.call(request, self._options.connect_timeout_s, keep=_UNKNOWN)
        except TimeoutError:
            missing = f"no answer to {endpoint}"
            raise busy_server(WHO, self._skill, self._options, missing) from None
        except ServerError as error:
            if error.said.startswith(_UNKNOWN):
                return None
            raise

    def call(self, request: Mapping[str, object], timeout_s: float, keep: str = "\0") -> object:
        """One exchange; after a failure there is no socket any more.

        Args:
            keep: words of an error after which there is.

        Raises:
            ServerError: for an answer that is an error.
            PolicyError: for one that is no message.
            TimeoutError: for none.
        """
        if self._socket is None:
            raise PolicyError(f"{WHO}: asked without a connection")
        signed = request if self._key is None else {**request, "api_token": self._key}
        self._socket.send(encode(signed, self.arrays))
        if not self._socket.poll(int(timeout_s * 1000)):
            lost = self._is_lost()
            self.close()
            raise TimeoutError(
                f"no answer within {timeout_s:g} s" + ("; the link was lost meanwhile" * lost)
            )
        try:
            (said,) = self._socket.recv_multipart()  # of several parts it is none
            reply = decode(said)
        except NO_MESSAGE as error:
            self.close()
            address = self._options.address
            raise PolicyError(f"{WHO}: {address} answered no message: {error}") from None
        if self._is_lost():
            self.close()  # ZeroMQ dials anew silently: this may be another server's answer
            raise PolicyError(f"{WHO}: {self._options.address}: the link was lost meanwhile")
        if isinstance(reply, dict) and "error" in reply:
            failed = ServerError(self._options, str(reply["error"]))
            if keep not in failed.said:
                self.close()
            raise failed
        return reply

    def _is_lost(self) -> bool:
        """Whether the link was, since the socket was opened."""
        return self._monitor is not None and bool(self._monitor.poll(0))

    def close(self) -> None:
        """Leave; `dial` begins anew."""
        if self._socket is not None:
            self._socket.disable_monitor()
            self._socket.close(linger=0)
        if self._monitor is not None:
            self._monitor.close(linger=0)
        self._socket = self._monitor = None


def _listens(address: str) -> bool:
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), timeout=1.0):
            return True
    except OSError:
        return False
