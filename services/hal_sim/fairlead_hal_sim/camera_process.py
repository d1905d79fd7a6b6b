"""Renders cameras in a process of its own, from snapshots of the simulator's state.

Software rendering costs tens of milliseconds a frame and must not stall a control tick.
The child builds the same environment, puts it into each snapshot's poses and renders; it
ends by itself when the pipe to the HAL closes, however the HAL ended.
"""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from multiprocessing import Pipe
from multiprocessing.connection import Connection

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.deploy.scheduling import run_as_ordinary_process
from fairlead.jpeg import as_jpeg
from fairlead.messages import Image, decode, encode
from fairlead_hal_sim.graphics_choice import VARIABLE, renderers, why_none
from fairlead_hal_sim.options import CameraOptions, SimulatorOptions

_LOG = logging.getLogger("hal.cameras")

START_WAIT_S = 120.0
"""Building the environment takes seconds, on a busy machine tens of them."""


class FrameRequest(msgspec.Struct, frozen=True, array_like=True):
    """HAL to camera process: render these cameras from this snapshot."""

    session: int
    tick: int
    cameras: tuple[str, ...]
    snapshot: bytes


class FrameAnswer(msgspec.Struct, frozen=True, array_like=True):
    """Camera process to HAL: an encoded `Image`, or why there is none (both "" = ready)."""

    image: bytes
    failure: str


class CameraProcess:
    """The HAL's end of the pipe. Implements `fairlead.hal.backend.CameraFeed`."""

    def __init__(self, options: SimulatorOptions, control_hz: float, gl: str) -> None:
        self._pipe, theirs = Pipe()
        self._lock = threading.Lock()
        self._owed = 0
        self._failure = ""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "fairlead_hal_sim.camera_process", str(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            env={**os.environ, VARIABLE: gl},
        )
        theirs.close()
        plain = SimulatorOptions(
            **{name: getattr(options, name) for name in SimulatorOptions.model_fields}
        )
        self._pipe.send_bytes(plain.model_dump_json().encode())
        self._pipe.send_bytes(str(control_hz).encode())
        self._owed = 1

    @property
    def failure(self) -> str:
        """Why there will be no more frames; "" while all is well."""
        return self._failure

    def wait_ready(self) -> bool:
        """Wait until the child can render; False (and `failure` says why) if it cannot."""
        self.take(START_WAIT_S)
        if not self._failure and self._owed:
            self._fail(f"the camera process was not ready in {START_WAIT_S:g} s")
        return not self._failure

    def request(self, session: int, tick: int, cameras: Sequence[str], snapshot: bytes) -> bool:
        """Send a snapshot; False while frames are owed, or once the child has ended."""
        with self._lock:
            if self._owed or self._failure:
                return False
            self._owed = len(cameras)
        message = FrameRequest(session, tick, tuple(cameras), snapshot)
        try:
            self._pipe.send_bytes(msgspec.msgpack.encode(message))
        except OSError:
            self._fail("the camera process has ended")
        return not self._failure

    def take(self, timeout_s: float) -> Image | None:
        """The next frame the child has finished; None if none came within ``timeout_s``."""
        try:
            if not self._pipe.poll(timeout_s):
                return None
            answer = msgspec.msgpack.decode(self._pipe.recv_bytes(), type=FrameAnswer)
        except (EOFError, OSError):
            self._fail("the camera process has ended")
            return None
        with self._lock:
            self._owed -= 1
        if answer.failure:
            self._fail(answer.failure)
        return decode(Image, answer.image) if answer.image else None

    def close(self) -> None:
        """End the child at once: it has nothing to put in order, and a HAL has 4 s to end."""
        self._fail("closed")
        self._pipe.close()
        self._process.kill()
        self._process.wait()

    def _fail(self, reason: str) -> None:
        self._failure = self._failure or reason


def start_camera_process(options: SimulatorOptions, control_hz: float) -> CameraProcess | None:
    """Start rendering with the first graphics library that works; None if none does."""
    for gl in renderers():
        process = CameraProcess(options, control_hz, gl)
        if process.wait_ready():
            _LOG.info("cameras render with MUJOCO_GL=%s", gl)
            return process
        _LOG.warning("cannot render with MUJOCO_GL=%s: %s", gl, process.failure)
        process.close()
    _LOG.error("cameras off: %s", why_none())
    return None


def serve(pipe: Connection) -> None:
    """The child's life: build, say ready, answer requests until the pipe closes."""
    options = SimulatorOptions.model_validate_json(pipe.recv_bytes())
    control_hz = float(pipe.recv_bytes())
    # Imported here: MUJOCO_GL must be set first, and the HAL's end does without.
    from fairlead_hal_sim.environment import make_environment
    from fairlead_hal_sim.snapshot import restore_snapshot

    cameras = {camera.name: camera for camera in options.cameras}
    env = make_environment(options, control_hz, offscreen=True)
    env.reset()
    for camera in cameras.values():
        _render(env.sim, camera)
    _answer(pipe, FrameAnswer(b"", ""))
    while True:
        request = msgspec.msgpack.decode(pipe.recv_bytes(), type=FrameRequest)
        restore_snapshot(env.sim, request.snapshot)
        for name in request.cameras:
            pixels, quality = _render(env.sim, cameras[name]), cameras[name].jpeg_quality
            image = Image(
                session=request.session,
                tick=request.tick,
                camera=name,
                width=cameras[name].width,
                height=cameras[name].height,
                encoding_name="jpeg" if quality else "rgb8",
                data=as_jpeg(pixels, quality) if quality else pixels.tobytes(),
            )
            _answer(pipe, FrameAnswer(encode(image), ""))


def _render(sim: object, camera: CameraOptions) -> npt.NDArray[np.uint8]:
    """RGB rows, top first (robosuite's come bottom first)."""
    image: npt.NDArray[np.uint8] = sim.render(  # type: ignore[attr-defined]
        camera_name=camera.name, width=camera.width, height=camera.height
    )
    return image[::-1]


def _answer(pipe: Connection, answer: FrameAnswer) -> None:
    pipe.send_bytes(msgspec.msgpack.encode(answer))


def main() -> None:
    """Entry point of the child; its only argument is the pipe's file descriptor."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the HAL, which closes the pipe
    run_as_ordinary_process()
    pipe = Connection(int(sys.argv[1]))
    try:
        serve(pipe)
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return  # the HAL has ended
    except Exception as error:  # noqa: BLE001 - whatever the graphics library raises is told
        _answer(pipe, FrameAnswer(b"", f"{type(error).__name__}: {error}"))


if __name__ == "__main__":
    main()
