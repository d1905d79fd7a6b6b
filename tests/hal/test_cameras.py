"""Frames of the real simulator, rendered in a process of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.equipment.rendering import CAN_RENDER
from fairlead.errors import ConfigError
from fairlead.messages import HalStatus, Image, StatusQuery, decode
from fairlead_hal_sim import graphics_choice
from fairlead_hal_sim.camera_process import start_camera_process
from fairlead_hal_sim.options import CameraOptions, SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from tests.hal.hal_process import HalProcess

pytestmark = [pytest.mark.simulator, pytest.mark.processes]

CAMERA = CameraOptions(name="overview", width=96, height=64, period_ticks=5)


def pixels(image: Image) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    shape = (image.height, image.width, 3)
    return np.frombuffer(image.data, dtype=np.uint8).reshape(shape).astype(np.float64)


@pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine")
def test_a_frame_shows_the_snapshot_right_side_up_and_carries_its_tick() -> None:
    options = SimulatorOptions(cameras=(CAMERA,))
    backend = RobosuiteBackend(options)
    feed = start_camera_process(options, 20.0)
    assert feed is not None
    try:
        frames = []
        for tick, seed in ((1, 0), (6, 0), (11, 5)):
            backend.reset(seed)
            assert feed.request(7, tick, ["overview"], backend.snapshot())
            image = feed.take(30.0)
            assert image is not None, feed.failure
            assert (image.session, image.tick, image.camera) == (7, tick, "overview")
            assert (image.width, image.height, image.encoding_name) == (96, 64, "rgb8")
            frames.append(pixels(image))
        assert np.array_equal(frames[0], frames[1]), "the same state looks the same"
        assert not np.array_equal(frames[0], frames[2]), "another seed looks different"
        # The overview looks down on a dark floor, with a light wall behind it.
        assert frames[0][:8].mean() > frames[0][-8:].mean() + 10
    finally:
        feed.close()
        backend.close()


def test_lockstep_sends_the_due_frames_with_every_repeat_of_the_tick(tmp_path: Path) -> None:
    hal = HalProcess(tmp_path, "lockstep", run="hal_sim", cameras=[CAMERA.model_dump()])
    status = decode(HalStatus, hal.bus.query(hal.keys.hal_status, StatusQuery(), 10.0))
    assert [camera.name for camera in status.cameras] == ["overview"]
    if CAN_RENDER:
        images = hal.collect(hal.keys.camera("overview"), 3)
        assert len({sample.payload for sample in images}) == 1
        assert decode(Image, images[0].payload).tick == 1
    else:
        hal.wait_until(lambda: "install libegl1 or libosmesa6" in hal.log.read_text(), "the log")
    hal.close()


def test_a_camera_the_environment_does_not_have_is_refused_with_those_it_has() -> None:
    attic = CAMERA.model_copy(update={"name": "attic"})
    with pytest.raises(ConfigError, match="'attic' .valid: overview, top"):
        RobosuiteBackend(SimulatorOptions(cameras=(attic,)))


@pytest.mark.thorough
def test_without_a_working_renderer_the_hal_runs_and_says_that_cameras_are_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "glx")  # needs a screen
    monkeypatch.delenv("DISPLAY", raising=False)
    hal = HalProcess(tmp_path, "lockstep", run="hal_sim", cameras=[CAMERA.model_dump()])
    hal.collect(hal.keys.joints, 2)
    status = decode(HalStatus, hal.bus.query(hal.keys.hal_status, StatusQuery(), 10.0))
    assert status.detail == "cameras off: no renderer was started"
    assert status.cameras == ()
    assert "install libegl1 or libosmesa6" in hal.log.read_text()
    hal.close()


def test_a_choice_that_renders_nothing_is_said_in_one_line_and_the_hal_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "vulkan")
    hal = HalProcess(tmp_path, "lockstep", run="hal_sim", cameras=[CAMERA.model_dump()])
    hal.collect(hal.keys.joints, 2)
    log = hal.log.read_text()
    why = "expected a renderer, got 'vulkan' (valid: egl, osmesa, glfw, glx, disabled)"
    assert f"cameras off: MUJOCO_GL: {why}\n" in log
    assert "Traceback" not in log
    hal.close()


def test_an_operator_who_switches_rendering_off_is_told_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(graphics_choice, "CHOICE", "disable")
    assert graphics_choice.renderers() == []
    assert graphics_choice.why_none() == "MUJOCO_GL=disable switches rendering off"
