"""Tiny policy servers that speak the two wires, written down here a second time by hand."""

from __future__ import annotations

import io
import socket
import threading
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import zmq
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Response
from websockets.sync.server import Server, ServerConnection, serve

Array = np.ndarray[Any, np.dtype[Any]]
Document = Any

ANSWERS = Callable[[Document, int], bytes | bytearray | str | list[bytes] | None]
"""What to send for the nth request (0 is the first); None: nothing; a bytearray: as it is on the
wire, of which nothing else follows; a list: the parts of one message."""

DEEP = b"\x91" * 50_000 + b"\xc0"
"""A list in a list in a list ..., in msgpack."""


RLDX_SHARES = {"end_effector_position": (0, 3), "end_effector_rotation": (3, 6),
          "gripper_close": (6, 7), "base_motion": (7, 11), "control_mode": (11, 12)}  # fmt: skip
"""Columns of a row of 12 numbers, by the name under which an RLDX server sends them."""


def openpi_array(array: Array) -> dict[bytes, Any]:
    return {
        b"__ndarray__": True,
        b"data": array.tobytes(),
        b"dtype": array.dtype.str,
        b"shape": array.shape,
    }


def openpi_actions(array: Array) -> bytes:
    return msgspec.msgpack.encode(
        {"actions": openpi_array(array), "server_timing": {"infer_ms": 1.5}}
    )


def read_openpi_array(packed: dict[bytes, Any]) -> Array:
    return np.frombuffer(packed[b"data"], packed[b"dtype"]).reshape(packed[b"shape"])


def npy(array: Array) -> dict[str, Any]:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return {"__ndarray_class__": True, "as_npy": file.getvalue()}


def read_npy(packed: dict[str, Any]) -> Array:
    loaded: Array = np.load(io.BytesIO(packed["as_npy"]), allow_pickle=False)
    return loaded


def rldx_rows(rows: Array) -> dict[str, Array]:
    return {name: rows[:, first:last] for name, (first, last) in RLDX_SHARES.items()}


def rldx_actions(arrays: dict[str, Array]) -> bytes:
    named = {f"action.{name}": npy(array[None]) for name, array in arrays.items()}
    return msgspec.msgpack.encode([named, {}])


class OpenpiServer:
    """Greets with its metadata, then answers as told.

    Args:
        guard: what to say to a handshake; None lets all in.
    """

    def __init__(
        self,
        answers: ANSWERS,
        port: int = 0,
        greeting: bytes | str = b"\x81\xa3who\xa4test",
        guard: Callable[[ServerConnection, Any], Response | None] | None = None,
    ) -> None:
        self.requests: list[Document] = []
        self.connections = 0
        self._greeting = greeting
        self.go_on = threading.Event()
        self._answers = answers
        self._server: Server = serve(
            self._handle,
            "127.0.0.1",
            port,
            compression=None,
            max_size=None,
            process_request=guard,
        )
        self.address = f"ws://127.0.0.1:{self._server.socket.getsockname()[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever)
        self._thread.start()

    def _handle(self, link: ServerConnection) -> None:
        self.connections += 1
        link.send(self._greeting)
        try:
            while True:
                request = link.recv()
                assert isinstance(request, bytes)
                self.requests.append(msgspec.msgpack.decode(request))
                answer = self._answers(self.requests[-1], len(self.requests) - 1)
                if answer is None:
                    link.close()
                    return
                assert not isinstance(answer, list)
                if isinstance(answer, bytearray):
                    link.socket.sendall(answer)
                    link.socket.shutdown(socket.SHUT_RDWR)
                    return
                link.send(answer)
                if isinstance(answer, str):
                    link.close(1011)
        except ConnectionClosed:
            pass  # the policy hung up, as some of these tests want it to

    def close(self) -> None:
        self.go_on.set()
        self._server.shutdown()
        self._thread.join()


def modality_config(
    video: list[int], state: list[str], actions: list[str], horizon: int, language: str,
    pictures: list[str], marker: str = "__ModalityConfig_class__",
) -> dict[str, Any]:  # fmt: skip
    """What ``get_modality_config`` answers: ``to_json_serializable`` of four ModalityConfigs."""

    def entry(deltas: list[int], names: list[str]) -> dict[str, Any]:
        block = {
            "delta_indices": deltas, "modality_keys": names, "sin_cos_embedding_keys": None,
            "mean_std_embedding_keys": None, "action_configs": None,
        }  # fmt: skip
        return {marker: True, "as_json": block}

    return {
        "video": entry(video, pictures),
        "state": entry([0], state),
        "action": entry(list(range(horizon)), actions),
        "language": entry([0], [language]),
    }


class RldxServer:
    """Answers pings and resets itself, ``get_action`` as told, and with its config if it has one.

    Attributes:
        config: the answer to ``get_modality_config``; None: it has no such endpoint.
        api_token: without which it answers nobody; None: it answers all.
        resets: the options of each reset.
    """

    def __init__(self, answers: ANSWERS, port: int = 0, host: str = "127.0.0.1") -> None:
        self.requests: list[Document] = []
        self.resets: list[Document] = []
        self.config: Document = None
        self.api_token: str | None = None
        self.go_on = threading.Event()
        self._answers = answers
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.REP)
        self._socket.setsockopt(zmq.IPV6, 1)
        if port:
            self._socket.bind(f"tcp://{host}:{port}")
        else:
            port = self._socket.bind_to_random_port(f"tcp://{host}")
        self.address = f"tcp://{host}:{port}"
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._stopping.is_set():
            if not self._socket.poll(50):
                continue
            request = msgspec.msgpack.decode(self._socket.recv())
            quick = self._quick(request)
            if quick is not None:
                self._socket.send(msgspec.msgpack.encode(quick))
                continue
            self.requests.append(request["data"])
            answer = self._answers(request["data"], len(self.requests) - 1)
            assert isinstance(answer, bytes | list)
            self._socket.send_multipart(answer if isinstance(answer, list) else [answer])

    def _quick(self, request: Document) -> Document:
        if self.api_token is not None and request.get("api_token") != self.api_token:
            return {"error": "Unauthorized: Invalid API token"}
        match request["endpoint"]:
            case "ping":
                return {"status": "ok"}
            case "reset":
                self.resets.append(request["data"]["options"])
                return {"cleared_sessions": []}
            case "get_modality_config" if self.config is None:
                return {"error": "Unknown endpoint: get_modality_config"}
            case "get_modality_config":
                return self.config
        return None

    def close(self) -> None:
        self.go_on.set()
        self._stopping.set()
        self._thread.join()
        self._socket.close(linger=0)
        self._context.term()
