"""From the policy's rows to a candidate: the chunk that is proposed to the gate."""

from __future__ import annotations

from fairlead.messages import ActionChunk, encode
from fairlead.policy import Actions
from fairlead_skill_runner.chunk_book import SentChunk
from fairlead_skill_runner.control_rows import control_rows
from fairlead_skill_runner.dispatch import dispatch
from fairlead_skill_runner.intake import Gathered
from fairlead_skill_runner.run_setup import RunSetup


def candidate(
    setup: RunSetup, seq: int, asked: Gathered, actions: Actions, now_tick: int
) -> SentChunk:
    """The chunk of all parts for one answer of the policy, encoded once.

    Lockstep: only the rows that will be executed; realtime: all, the gate drops by index
    those that have passed.

    Args:
        seq: the chunk's number within the claim.
        asked: the observation the policy answered; its tick is the first row's.
        actions: float32 ``[H, dim]``, the policy's answer.
        now_tick: the newest tick, from which the gate's verdict is awaited.

    Raises:
        ConfigError: if ``actions`` is not as wide as the skill's action contract.
    """
    steps = min(len(actions), setup.skill.execute_steps) if setup.lockstep else len(actions)
    horizon = steps * setup.periods
    tick = asked.observation.tick
    message = ActionChunk(
        robot_hash=setup.robot_hash,
        session=setup.session,
        epoch=setup.epoch,
        claim_id=setup.claim_id,
        source=setup.source,
        seq=seq,
        goal_id=setup.goal_id,
        obs_tick=tick,
        oldest_tick=asked.oldest_tick,
        start_tick=tick,
        horizon=horizon,
        parts=control_rows(
            dispatch(setup.routes, actions, setup.skill.action_contract.dim),
            [route.width for route in setup.routes],
            setup.periods,
            setup.skill.between,
            horizon,
        ),
        trace=setup.trace_of(seq),
    )
    return SentChunk(seq, tick, horizon, now_tick, encode(message))
