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

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fairlead.deploy.deployment import Deployment as Deployment
    from fairlead.deploy.deployment import load_deployment as load_deployment
    from fairlead.errors import FairleadError as FairleadError
    from fairlead.keys import Keys as Keys
    from fairlead.modes import ControlMode as ControlMode
    from fairlead.operate.client import RobotClient as RobotClient
    from fairlead.operate.connection import connect as connect
    from fairlead.operate.goal import Progress as Progress
    from fairlead.operate.goal import RunningGoal as RunningGoal
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
    from fairlead.wire.memory_bus import MemoryBus as MemoryBus
    from fairlead.wire.session import Endpoints as Endpoints
    from fairlead.wire.session import ZenohBus as ZenohBus

_HOME = {
    "Bus": "wire.bus",
    "ControlMode": "modes",
    "Deployment": "deploy.deployment",
    "Endpoints": "wire.session",
    "FairleadError": "errors",
    "Keys": "keys",
    "MemoryBus": "wire.memory_bus",
    "Qos": "wire.bus",
    "PartClaim": "operate.part_claim",
    "Progress": "operate.goal",
    "Robot": "operate.robot",
    "RobotClient": "operate.client",
    "RobotManifest": "robot.manifest",
    "RobotStatus": "operate.services",
    "RunningGoal": "operate.goal",
    "Sample": "wire.bus",
    "SkillManifest": "skill.manifest",
    "StateContractBindings": "skill.bindings",
    "ZenohBus": "wire.session",
    "Subscription": "operate.subscription",
    "Tick": "operate.tick",
    "connect": "operate.connection",
    "load_deployment": "deploy.deployment",
    "load_robot": "robot.manifest",
    "load_skill": "skill.manifest",
}
__all__ = list(_HOME)


def __getattr__(name: str) -> object:
    """Load a public name from its module when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
