"""A new episode and a second HAL: what the HAL's process refuses and how it restarts the scene."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.errors import RefusedError
from fairlead.messages import (
    Hold,
    JointState,
    ResetEpisode,
    ResetEpisodeReply,
    decode,
    floats,
)
from fairlead_tools.supervisor.this_host import free_ports
from tests.hal.hal_process import START_S, HalProcess
from tests.hal.live_gate import LiveGate

pytestmark = pytest.mark.processes


def reset(hal: HalProcess, seed: int) -> ResetEpisodeReply:
    key = hal.keys.hal_command("reset_episode")
    return decode(ResetEpisodeReply, hal.bus.query(key, ResetEpisode(seed=seed), 20.0))


def test_reset_episode_is_refused_until_a_lease_says_disarmed(lockstep: HalProcess) -> None:
    with pytest.raises(RefusedError, match="no lease received, so the gate may be armed"):
        reset(lockstep, seed=3)
    with closing(LiveGate(lockstep.bus, lockstep.keys)) as gate:
        lockstep.wait_until(lambda: gate.newest_tick == 1, "the first state")
        gate.arm()
        lockstep.wait_until(lambda: refusal(lockstep) != "no lease", "a lease")
        with pytest.raises(RefusedError, match="needs a disarmed gate, it is armed") as caught:
            reset(lockstep, seed=3)
        assert caught.value.fix == "fairlead disarm"


def refusal(hal: HalProcess) -> str:
    with pytest.raises(RefusedError) as caught:
        reset(hal, seed=3)
    return caught.value.reason[:8]


def test_reset_episode_steps_held_ticks_until_standstill_and_starts_an_episode(
    lockstep: HalProcess,
) -> None:
    with closing(LiveGate(lockstep.bus, lockstep.keys)) as gate:
        lockstep.wait_until(lambda: gate.newest_tick == 1, "the first state")
        reply = reset(lockstep, seed=3)
        assert (reply.tick, reply.episode_tick, reply.held_ticks) == (2, 2, 1)
        lockstep.wait_until(lambda: len(lockstep.motion()) == 1, "the held tick")
        (line,) = lockstep.motion()
        assert {part[0] for part in line["acted"]} == {Hold.RESETTING}
        assert line["event"] == "reset_episode seed 3"
        state = decode(JointState, lockstep.collect(lockstep.keys.joints, 1)[0].payload)
        assert (state.tick, state.episode_tick) == (2, 2)
        first = floats(state.positions)
        reply = reset(lockstep, seed=4)
        assert (reply.tick, reply.episode_tick, reply.held_ticks) == (3, 3, 1)
        other = floats(
            decode(JointState, lockstep.collect(lockstep.keys.joints, 1)[0].payload).positions
        )
        assert not np.array_equal(first, other)


def second_hal(first: HalProcess, spec: dict[str, Any], state_dir: Path) -> str:
    """What another HAL says before it ends."""
    log = first.folder / "second.log"
    second = first.launch(spec, state_dir, log)
    try:
        assert second.wait(START_S) == 1, log.read_text()
    finally:
        second.kill()
        second.wait()
    return log.read_text()


def test_a_second_hal_on_the_same_port_says_what_to_look_for(realtime: HalProcess) -> None:
    said = second_hal(realtime, realtime.spec, realtime.folder / "other")
    assert "in use by another process; see which: fairlead ps" in said


def beside(first: HalProcess) -> dict[str, Any]:
    """The same robot with a HAL on a port of its own, which can see the first."""
    services = {
        "first": first.spec["services"]["hal"],
        "hal": {"run": "hal_sim", "listen": f"tcp/127.0.0.1:{free_ports(1)[0]}"},
    }
    return {**first.spec, "services": services}


def test_a_second_hal_that_can_see_the_first_names_it(realtime: HalProcess) -> None:
    said = second_hal(realtime, beside(realtime), realtime.folder / "b")
    assert f"robot {realtime.keys.robot} already has a HAL (process {realtime.process.pid} " in said


def test_a_second_hal_in_the_same_state_folder_is_refused(realtime: HalProcess) -> None:
    services = {"hal": {"run": "hal_sim", "listen": f"tcp/127.0.0.1:{free_ports(1)[0]}"}}
    said = second_hal(realtime, {**realtime.spec, "services": services}, realtime.state_dir)
    assert f"another HAL still uses {realtime.state_dir}" in said
