"""Unchanged servers of others, from checkouts that a person names, drive the shipped skills."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from bench.equipment.live_robot import wait_for
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.peers.environment import checkouts
from tests.peers.rows import HORIZON, overshooting
from tests.peers.serve_openpi import FAILING, HANGING
from tests.peers.served import admitted_rows, made, serving
from tests.runner.asked_policies import PI05, failure, late, observation

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]


AT_ONCE = (str(HORIZON), "0")


def test_openpi_s_server_drives_the_pi05_skill(capfd: pytest.CaptureFixture[str]) -> None:
    [checkout] = checkouts("OPENPI")
    skill = load_skill(PI05)
    with serving("serve_openpi", str(checkout), *AT_ONCE) as port:
        policy = made(skill, OpenpiPolicy, f"ws://127.0.0.1:{port}")
        assert "tells of itself: reset_pose; asked with a probe " in capfd.readouterr().err
        policy.reset()
        rows = policy.infer(observation(skill))
        assert rows.tobytes() == overshooting().tobytes()
        assert np.abs(admitted_rows(skill, rows)[:, :10]).max() == 1.0
        text = failure(lambda: policy.infer(replace(observation(skill), prompt=FAILING)))
        assert text.endswith("failed: RuntimeError: out of memory, as told")
        said = capfd.readouterr().err
        assert "Traceback (most recent call last):" in said
        assert "websocket_policy_server.py" in said
        policy.reset()
        assert policy.infer(observation(skill)).tobytes() == overshooting().tobytes()
        policy._close()


def test_openpi_s_server_of_more_rows_than_the_skill_takes_is_refused_at_load() -> None:
    [checkout] = checkouts("OPENPI")
    with serving("serve_openpi", str(checkout), "100", "0") as port:
        text = failure(lambda: made(load_skill(PI05), OpenpiPolicy, f"ws://127.0.0.1:{port}"))
    assert text.endswith("expected actions as floats [1 to 50, 12], got float64 [100, 12]")


def test_openpi_s_server_that_was_started_anew_compiles_again_before_the_claim() -> None:
    [checkout] = checkouts("OPENPI")
    skill = load_skill(PI05)
    with serving("serve_openpi", str(checkout), *AT_ONCE) as port:
        policy = made(skill, OpenpiPolicy, f"ws://127.0.0.1:{port}", answer_timeout_s=2.0)
        policy.reset()
        assert policy.infer(observation(skill)).tobytes() == overshooting().tobytes()
    with serving("serve_openpi", str(checkout), str(HORIZON), "4", port=port):
        policy.reset()
        assert policy.infer(observation(skill)).tobytes() == overshooting().tobytes()
        policy._close()


def test_openpi_s_server_that_infers_for_another_is_called_busy_not_absent(
    capfd: pytest.CaptureFixture[str],
) -> None:
    [checkout] = checkouts("OPENPI")
    skill, said = load_skill(PI05), [""]

    def hangs() -> bool:
        said[0] += capfd.readouterr().err
        return f"{HANGING} as told" in said[0]

    with ThreadPoolExecutor(1) as pool:
        with serving("serve_openpi", str(checkout), *AT_ONCE) as port:
            address = f"ws://127.0.0.1:{port}"
            first = made(skill, OpenpiPolicy, address)
            asked = replace(observation(skill), prompt=HANGING)
            ended = pool.submit(failure, lambda: first._ask(asked, 100.0))
            wait_for(hangs, "the server infers", 60.0)
            text = failure(lambda: made(skill, OpenpiPolicy, address, connect_timeout_s=1.0))
        assert "closed the connection" in ended.result()
    awaited = "sent no websocket handshake within 1 s"
    assert f"{address} listens, but {awaited}: it is busy with another request" in text


@pytest.mark.parametrize(
    ("variable", "name", "config", "frames", "others"),
    [
        ("GROOT", "gr00t-robocasa", "GR00T-N1.6-3B", 1, 4),
        ("RLDX", "rldx1-ft-rc365-nf4", "robocasa365_config", 4, 1),
        ("RLDX", "rldx-robocasa", "robocasa_config", 4, 1),
    ],
)
def test_a_server_with_its_own_names_drives_its_skill_and_with_other_frames_is_refused(
    variable: str, name: str, config: str, frames: int, others: int
) -> None:
    skill = load_skill(name)
    for checkout in checkouts(variable):
        with serving("serve_zmq", str(checkout), config, str(frames)) as port:
            policy = made(skill, RldxZmqPolicy, f"tcp://127.0.0.1:{port}")
            policy.reset()
            rows = policy.infer(observation(skill))
            assert rows.tobytes() == overshooting().tobytes()
            assert np.abs(admitted_rows(skill, rows)[:, :10]).max() == 1.0
            policy._link.close()
        with serving("serve_zmq", str(checkout), config, str(others)) as port:
            address = f"tcp://127.0.0.1:{port}"
            text = failure(lambda: made(skill, RldxZmqPolicy, address))  # noqa: B023
            assert f"it wants frames at deltas {[2 * i for i in range(1 - others, 1)]}" in text


RC365 = ("robocasa365_config", "4")


def test_rldx_s_own_code_takes_the_rows_that_act_meanwhile() -> None:
    skill = load_skill("rldx1-ft-rc365-nf4")
    for checkout in checkouts("RLDX"):
        with serving("serve_zmq", str(checkout), *RC365, "rtc") as port:
            policy = made(skill, RldxZmqPolicy, f"tcp://127.0.0.1:{port}", rtc=True)
            policy.reset()
            assert policy.infer(observation(skill)).tobytes() == overshooting().tobytes()
            for count in (1, 3):
                seen, acting = late(observation(skill), 12, count)
                rows = policy.infer(seen)
                np.testing.assert_allclose(rows[:count], acting, atol=1e-6)
                assert rows[count:].tobytes() == overshooting()[count:].tobytes()
            policy._link.close()


def test_rldx_s_server_goes_on_from_no_rows_of_its_own_where_the_skill_has_no_rtc(
    capfd: pytest.CaptureFixture[str],
) -> None:
    skill = load_skill("rldx1-ft-rc365-nf4")
    for checkout in checkouts("RLDX"):
        with serving("serve_zmq", str(checkout), *RC365, "rtc") as port:
            policy = made(skill, RldxZmqPolicy, f"tcp://127.0.0.1:{port}")
            assert "every request switches its real-time chunking off" in capfd.readouterr().err
            for _ in range(3):
                assert policy.infer(observation(skill)).tobytes() == overshooting().tobytes()
            policy._link.close()


def test_rldx_s_server_without_rtc_is_refused_a_skill_that_wants_it() -> None:
    skill = load_skill("rldx1-ft-rc365-nf4")
    for checkout in checkouts("RLDX"):
        with serving("serve_zmq", str(checkout), *RC365) as port:
            address = f"tcp://127.0.0.1:{port}"
            text = failure(lambda: made(skill, RldxZmqPolicy, address, rtc=True))  # noqa: B023
            assert f"rtc: {address} takes no prefix: start RLDX-1's server with " in text
