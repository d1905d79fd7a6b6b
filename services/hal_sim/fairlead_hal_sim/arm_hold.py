"""How an arm of robosuite holds: its pose controller has no hold of its own.

A zero delta puts its goal where the tool is, in every period anew: what pushes the arm away in
between, a base that drives off above all, is kept, and after a full-scale delta the tool goes on
for 0.1 m.
"""

from __future__ import annotations

from typing import Any

import numpy as np

DECELERATION = 20.0
"""Of each joint where an arm begins to hold [rad/s2]: as any of these joints is declared to."""

STIFFNESS = 60.0
"""Frequency of the critically damped servo that then keeps the joints there [1/s]."""

PULL_MOST = 0.015
"""A joint that was pushed away is pulled back as from this far [rad] at most, so by 0.45 rad/s.

A base that turns to and fro pushes harder than the drives can. What came back as fast as it could
was pushed again on its way, each time faster, up to 3.1 rad/s.
"""

SLOWING = 100.0
"""With a `joint_speed_guard`: by which share of what is too fast, in a second [1/s]."""


class ArmHold:
    """Stands in front of one arm's controller.

    In a period in which the arm `is_held`, each joint brakes with `DECELERATION` from the speed it
    had in the first such period, and stays where that ends. In other periods the controller's
    torques act, as they are or, with a guard, less what would make joints faster.

    Args:
        joint_speed_guard: joints faster than this are slowed down [rad/s]; None: none is.
    """

    def __init__(self, controller: Any, joint_speed_guard: float | None) -> None:
        self.is_held = False
        self._controller, self._fastest = controller, joint_speed_guard
        self._run, self._set_goal = controller.run_controller, controller.set_goal
        self._position = self._speed = np.zeros(0)
        controller.run_controller, controller.set_goal = self._torques, self._goal

    def _goal(self, action: Any) -> None:
        """Once a period. While the arm holds, the goal is the tool: rows go on from there."""
        if self.is_held:
            self._controller.set_goal_update_mode("achieved")
        else:
            self._position = np.zeros(0)
        self._set_goal(action)

    def _torques(self) -> Any:
        arm = self._controller
        if self.is_held:
            arm.torques = self._holding()
        elif self._fastest is None:
            self._run()
        else:
            driving = self._run()
            beyond = np.maximum(np.abs(arm.joint_vel) - self._fastest, 0.0) * np.sign(arm.joint_vel)
            arm.torques = driving - arm.mass_matrix @ (SLOWING * beyond)
        return arm.torques

    def _holding(self) -> Any:
        arm = self._controller
        arm.update()
        arm.new_update = True
        if not self._position.size:
            self._position, self._speed = arm.joint_pos.copy(), arm.joint_vel.copy()
        step_s = arm.sim.model.opt.timestep
        braking = np.clip(-self._speed / step_s, -DECELERATION, DECELERATION)
        self._speed = self._speed + braking * step_s
        self._position = self._position + self._speed * step_s
        wanted = (
            braking
            + 2.0 * STIFFNESS * (self._speed - arm.joint_vel)
            + STIFFNESS**2 * np.clip(self._position - arm.joint_pos, -PULL_MOST, PULL_MOST)
        )
        return arm.mass_matrix @ wanted + arm.torque_compensation
