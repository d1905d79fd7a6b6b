"""Admission: may this skill run on this robot, and if not, every reason why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

from fairlead.deploy.shipped_deployments import shipped_deployments
from fairlead.errors import ConfigError, expected
from fairlead.frames import MAP, ODOM
from fairlead.layout import load_layout
from fairlead.messages import HalStatus
from fairlead.modes import ControlMode
from fairlead.robot.description import description_tree
from fairlead.robot.home_check import singular_homes
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.camera_check import camera_problems, way_to_cameras
from fairlead.skill.limit_overrides import limit_problems
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.output_range import declared_range_problems, hal_range_problems
from fairlead.skill.routes import Route, plan_routes, resolve_routes
from fairlead.skill.state_contract import StateContract


class Admission:
    """What speaks against running a skill on a robot.

    The manifests are compared when it is first asked, which compiles the robot's gate files; then
    any number of HALs can be held against the result.

    Attributes:
        skill, robot: what is compared.
        routes: of the skill's slots on this robot; all of them, once `require` let the skill pass.
    """

    def __init__(self, skill: SkillManifest, robot: RobotManifest) -> None:
        self.skill, self.robot = skill, robot
        self.routes, self._slot_problems = plan_routes(skill.action_contract, robot)

    @cached_property
    def _of_manifests(self) -> list[str]:
        skill, robot = self.skill, self.robot
        return [
            *_embodiment_problems(skill, robot),
            *self._slot_problems,
            *([] if self._slot_problems else _switch_problems(self.routes, robot)),
            *([] if self._slot_problems else _unclaimed_limits(skill, self.routes, robot)),
            *state_problems(skill.state_contract, robot),
            *_profile_problems(skill, self.routes, robot),
        ]

    def problems(self, hal: HalStatus | None = None) -> list[str]:
        """Every reason against; empty means admitted.

        Args:
            hal: what the running HAL found, for its command ranges, part order and cameras;
                None checks the manifests alone, with the ranges the robot declares.
        """
        periods = self.skill.control_periods(self.robot.tick_period_ns) or 1
        if hal is None:
            ranges = declared_range_problems(self.routes, self.robot, periods)
            return [*self._of_manifests, *ranges]
        identity = _identity_problems(self.robot, hal)
        ranges = [] if identity else hal_range_problems(self.routes, self.robot, hal, periods)
        return [
            *self._of_manifests,
            *identity,
            *ranges,
            *camera_problems(self.skill, hal.cameras, hal.period_ns),
        ]

    def require(self, hal: HalStatus | None = None) -> None:
        """Let the skill pass if it may run.

        Raises:
            ConfigError: with every reason of `problems`, and what to do.
        """
        skill, robot = self.skill, self.robot
        problems = self.problems(hal)
        if not problems:
            return
        fix = f"fairlead skill ls --robot {robot.id}"
        if hal is not None and problems == camera_problems(skill, hal.cameras, hal.period_ns):
            fix = way_to_cameras(skill, robot, hal)
        elif hal is not None and not self.problems() and not _identity_problems(robot, hal):
            # `fairlead skill ls` would list it as admitted: it is this HAL that has too little.
            others = ", ".join(name for name, _ in shipped_deployments(robot.id)) or "none ships"
            fix = f"fairlead down, then fairlead up another deployment of {robot.id}: {others}"
        listed = "\n  ".join(summarised(problems, skill, robot))
        raise ConfigError(
            f"skill {skill.id} cannot run on robot {robot.id}:\n  {listed}\n  try: {fix}"
        )


def _unclaimed_limits(
    skill: SkillManifest, routes: Sequence[Route], robot: RobotManifest
) -> Iterator[str]:
    """A claim has limits for its own parts alone."""
    parts = robot.claimed_parts([route.part_name for route in routes])
    for part in dict.fromkeys(limit.part for limit in skill.limits):
        if part not in parts:
            yield expected("limits", "a part that the skill commands", repr(part), parts)


def admission_problems(
    skill: SkillManifest, robot: RobotManifest, hal: HalStatus | None = None
) -> list[str]:
    """`Admission.problems` of a skill that is asked about once."""
    return Admission(skill, robot).problems(hal)


def summarised(problems: Sequence[str], skill: SkillManifest, robot: RobotManifest) -> list[str]:
    """The problems for a person: of a skill made for other robots, that, and how many more."""
    if robot.id in skill.embodiments or len(problems) < 2:
        return list(problems)
    return [problems[0], f"and {len(problems) - 1} more, as on any robot it was not made for"]


def home_warnings(skill: SkillManifest, robot: RobotManifest) -> list[str]:
    """Tools that a skill moves, and that home is singular for; of a skill that is admitted."""
    singular, moved = singular_homes(robot), resolve_routes(skill.action_contract, robot)
    names = dict.fromkeys(route.part_name for route in moved if route.mode.is_tool_mode)
    return [singular[name] for name in names if name in singular]


def _embodiment_problems(skill: SkillManifest, robot: RobotManifest) -> list[str]:
    problems = []
    if robot.id not in skill.embodiments:
        problems.append(f"embodiments: made for {', '.join(skill.embodiments)}, not {robot.id}")
    rate_hz = 1e9 / robot.tick_period_ns
    if skill.control_periods(robot.tick_period_ns) is None:
        wanted = f"the robot's {rate_hz:g} Hz or a whole fraction of it"
        problems.append(f"rate_hz: expected {wanted}, got {skill.rate_hz:g}")
    return problems


def _profile_problems(
    skill: SkillManifest, routes: tuple[Route, ...], robot: RobotManifest
) -> list[str]:
    """Of several safety profiles the one that complains least.

    Which one holds is a matter of the deployment; its gate decides at the claim.
    """
    found = [
        [*_frame_problems(routes, robot, profile), *limit_problems(skill, robot, profile)]
        for profile in robot.safety
    ]
    return min(found, key=len, default=[])


def _switch_problems(routes: tuple[Route, ...], robot: RobotManifest) -> list[str]:
    """The composite switch says what an arm's commands mean: it goes with the arm."""
    if robot.has_arm([route.part_name for route in routes]):
        return []
    return [
        f"composite_mode: part {route.part_name} belongs to whoever commands an arm, and this "
        "skill commands none"
        for route in routes
        if route.mode is ControlMode.COMPOSITE_MODE
    ]


def _frame_problems(routes: tuple[Route, ...], robot: RobotManifest, profile: str) -> list[str]:
    """A frame that the profile does not declare: the gate would refuse every chunk."""
    problems = []
    for route in routes:
        limits = getattr(robot.profile(profile).parts[route.part_name], route.mode.yaml_name)
        frames = getattr(limits, "frames", (route.frame_id,))
        if route.frame_id not in frames:
            what = f"{route.mode.yaml_name} of part {route.part_name}"
            problems.append(
                f"{what}: the robot takes no frame {route.frame_id!r} "
                f"(valid: {', '.join(frames)}; profile {profile})"
            )
    return problems


def state_problems(contract: StateContract, robot: RobotManifest) -> list[str]:
    """Why the robot cannot fill a state vector.

    Joints it does not measure, or in other units; frames that nobody publishes; a layout that
    nothing assembles.
    """
    if contract.layout is None:
        return _joint_field_problems(contract, robot)
    layout = load_layout(contract.layout)
    if layout.assemble is None:
        return [f"layout {contract.layout}: no assembler; those that have one: fairlead layout ls"]
    bound = (
        ("joint_names", layout.bound_joints(contract.bindings)),
        ("gripper_qpos_joints", layout.bound_gripper(contract.bindings)),
    )
    return [
        *(text for binding, names in bound for text in _unmeasured_joints(binding, names, robot)),
        *_unknown_frames(contract.bindings, robot),
    ]


def _unknown_frames(bindings: StateContractBindings, robot: RobotManifest) -> list[str]:
    """Frames of neither the description nor the world nor a tracker."""
    known = (*description_tree(robot).frames, ODOM, MAP, *robot.tracked_frames)
    fields = [name for name in type(bindings).model_fields if name.endswith("_frame")]
    return [
        f"{binding}: robot {robot.id} has no frame {frame!r} (valid: {', '.join(known)}; what "
        "others publish is named in tracked_frames of robot.yaml)"
        for binding in fields
        if (frame := getattr(bindings, binding)) is not None and frame not in known
    ]


def _joint_field_problems(contract: StateContract, robot: RobotManifest) -> list[str]:
    problems = []
    types = {joint.name: joint.type for joint in (*robot.joints, *robot.passive_joints)}
    for index, field in enumerate(contract.joints):
        where = f"state_contract.joints.{index}"
        problems += _unmeasured_joints(where, field.names, robot)
        problems += [
            f"{where}: unit {field.unit} does not fit joint {name}, which is {types[name]} "
            f"(valid: {', '.join(field.units_of(types[name]))})"
            for name in field.names
            if name in types and field.unit not in field.units_of(types[name])
        ]
    return problems


def _unmeasured_joints(where: str, names: Sequence[str], robot: RobotManifest) -> list[str]:
    return [
        f"{where}: robot {robot.id} measures no joint {name!r} "
        f"(valid: {', '.join(robot.measured_joint_names)})"
        for name in names
        if name not in robot.measured_joint_names
    ]


def _identity_problems(robot: RobotManifest, hal: HalStatus) -> list[str]:
    pairs = (
        ("part order", robot.part_names, tuple(part.name for part in hal.parts)),
        ("joint order", robot.joint_names, hal.joints),
        ("passive joint order", robot.passive_joint_names, hal.passive_joints),
        ("robot hash", robot.robot_hash.hex()[:16], hal.robot_hash.hex()[:16]),
        ("control period [ns]", robot.tick_period_ns, hal.period_ns),
    )
    changed = (
        "; robot.yaml or its description is not what the HAL started with: "
        f"fairlead robot compile {robot.id}, then fairlead down and fairlead up"
    )
    return [
        f"{what}: the robot's manifest says {_plain(ours)}, the HAL says {_plain(theirs)}"
        + (changed if what == "robot hash" else "")
        for what, ours, theirs in pairs
        if ours != theirs
    ]


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)
