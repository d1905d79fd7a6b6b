"""Good demonstrations: what the shipped scripted skills tell each robot, chunk by chunk."""

from __future__ import annotations

from collections.abc import Mapping

from fairlead.errors import PolicyError
from fairlead.hal.backend import PartCommand
from fairlead.policy import Done, Failed, Observation
from fairlead.skill.manifest import load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner import dispatch, fitted
from fairlead_state_assembler import LocalAssembler
from fairlead_tools.measure.driven_robot import DrivenRobot
from fairlead_tools.parity.local_episode import asked, commands_of, make_policy, observe

SKILLS = {
    "panda_mobile": ("oracle-counter-to-cabinet",),
    "panda": ("panda-joint-reach",),
    "dual_panda": ("dual-panda-lift",),
    "ur5e": ("ur5e-tool-motion", "ur5e-reach"),
    "kinova3": ("kinova3-tool-motion", "kinova3-reach"),
    "so101": ("so101-tool-motion", "so101-reach"),
}
"""Of each robot, one after the other by seed."""
MOST_TICKS = {"oracle": 450, "joint_reach": 250, "constant": 250}
"""When a policy gives up, or its episode ends where there is no task."""
Rows = list[Mapping[str, PartCommand]]


class Demonstration:
    """One episode on a robot that has just been reset; the seed chooses among its skills."""

    def __init__(self, driven: DrivenRobot, seed: int) -> None:
        names = SKILLS[driven.robot.id]
        self._skill = load_skill(names[seed % len(names)])
        self._driven, self._policy = driven, make_policy("demonstration", self._skill)
        self._routes = resolve_routes(self._skill.action_contract, driven.robot)
        self._assembler = LocalAssembler(driven.robot)
        self._is_done = False
        self.most_ticks = MOST_TICKS[self._skill.policy.backend]

    def chunk(self, tick: int) -> Rows:
        """The next rows that act, from the one for ``tick`` on; none if the policy is done."""
        state = observe(self._assembler, self._driven.backend, self._skill)
        seen = Observation(tick, state, self._skill.prompt)
        said = asked("demonstration", self._policy, self._skill, seen)
        if isinstance(said, Failed):
            raise PolicyError(f"skill {self._skill.id} gave up in tick {tick}: {said.reason}")
        if isinstance(said, Done):
            self._is_done = True
            return []
        parts = dispatch(self._routes, fitted(self._routes, said), self._skill.action_contract.dim)
        rows = range(self._skill.execute_steps)
        return [commands_of(self._routes, parts, row) for row in rows]

    def is_over(self) -> bool:
        """Whether the task is done, by the policy or by the simulator."""
        task = self._driven.backend.task()
        return self._is_done or (task is not None and task.success)
