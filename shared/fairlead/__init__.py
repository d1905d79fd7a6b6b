"""Runs learned robot policies through typed commands and a safety gate.

What to import from where:

    fairlead                   talk to a running robot; load robots, skills, deployments
    fairlead.errors            every error that is raised on purpose, as a tree
    fairlead.messages          what is on the wire, and the codec
    fairlead.hal               connect a robot or a simulator: the contract
    fairlead.hal.process       ... and the process around it
    fairlead.layout            what a state layout is
    fairlead.policy            what a policy returns to end its goal
    fairlead.service           what the main of any service does
    fairlead_state_assembler   state vectors from joints and transforms

Everything else is the inside of these and may change. Names load when they are first
used: importing this package loads no transport and no simulator.
"""

from __future__ import annotations

import ast
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fairlead.deploy.deployment import Deployment as Deployment
    from fairlead.deploy.deployment import load_deployment as load_deployment
    from fairlead.errors import FairleadError as FairleadError
    from fairlead.keys import Keys as Keys
    from fairlead.modes import ControlMode as ControlMode
    from fairlead.operate.client import RobotClient as RobotClient
    from fairlead.operate.connection import connect as connect
    from fairlead.operate.goal import RunningGoal as RunningGoal
    from fairlead.operate.goal_hearing import Progress as Progress
    from fairlead.operate.part_claim import PartClaim as PartClaim
    from fairlead.operate.robot import Robot as Robot
    from fairlead.operate.services import RobotStatus as RobotStatus
    from fairlead.operate.subscription import Subscription as Subscription
    from fairlead.operate.tick import Tick as Tick
    from fairlead.robot.manifest import RobotManifest as RobotManifest
    from fairlead.robot.manifest import load_robot as load_robot
    from fairlead.skill.bindings import StateContractBindings as StateContractBindings
    from fairlead.skill.manifest import SkillManifest as SkillManifest
    from fairlead.skill.manifest import load_skill as load_skill
    from fairlead.wire.bus import Bus as Bus
    from fairlead.wire.bus import Qos as Qos
    from fairlead.wire.bus import Sample as Sample
    from fairlead.wire.endpoints import Endpoints as Endpoints
    from fairlead.wire.memory_bus import MemoryBus as MemoryBus
    from fairlead.wire.session import ZenohBus as ZenohBus


@cache
def _home() -> dict[str, str]:
    """The module of each public name: as the imports above say, which only type checkers run."""
    code = ast.parse(Path(__file__).read_text(encoding="utf-8"))
    imports = (node for node in ast.walk(code) if isinstance(node, ast.ImportFrom))
    return {name.asname: str(node.module) for node in imports for name in node.names if name.asname}


def __getattr__(name: str) -> object:
    """Load a public name from its module when it is first used."""
    if name == "__all__":
        return list(_home())
    if name not in _home():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_home()[name]), name)
