"""What is consistent between a robot's files and its HAL, what is missing, and each fix."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fairlead.errors import ConfigError
from fairlead.hal.frame_check import FrameError, frame_errors
from fairlead.messages import HalStatus
from fairlead.modes import ControlMode
from fairlead.paths import robot_dir
from fairlead.robot.capsules import load_capsules
from fairlead.robot.description import description_tree
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.gate_geometry import is_swept
from fairlead.robot.home_check import singular_homes
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import FrameTolerance
from fairlead_hal_mujoco import model_problems
from fairlead_tools.draft.servo_check import servo_findings
from fairlead_tools.shape.geometry import drawn_links, geometry_source
from fairlead_tools.shape.robot_model import ROBOSUITE, RobotModel, robot_model
from fairlead_tools.shape.robot_shape import RobotShape

WHO = "robot check"
OK, OPEN, MISSING, WRONG = "ok", "open", "missing", "wrong"
BAD = (MISSING, WRONG)
BENT = "bend joints in home of robot.yaml; joint modes lead out of it"


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at. state: ok, open (for a person to look at), missing, wrong."""

    subject: str
    state: str
    found: str
    fix: str = ""


@dataclass(frozen=True)
class FrameRow:
    """How far the model's frame is from the description's: at home, and at most in random poses."""

    frame: str
    home_mm: float
    home_rad: float
    random_mm: float
    random_rad: float


@dataclass(frozen=True)
class RobotCheck:
    """All that was found of one robot."""

    frames: Sequence[FrameRow]
    findings: Sequence[Finding]

    @property
    def is_good(self) -> bool:
        """Whether nothing is missing or wrong."""
        return not any(one.state in BAD for one in self.findings)


def check_robot(robot: RobotManifest, hal: HalStatus | None) -> RobotCheck:
    """Look at the URDF, the model, the capsules, the gate's files and the HAL.

    Args:
        hal: of the HAL that runs; None: none was asked.
    """
    try:
        frames = description_tree(robot).frames
    except ConfigError as error:
        return RobotCheck((), [Finding("URDF", WRONG, str(error), f"mend {robot.description}")])
    findings = [Finding("URDF", OK, f"{robot.description}: {len(frames)} links")]
    findings += [Finding("home", OPEN, one, BENT) for one in singular_homes(robot).values()]
    rows: list[FrameRow] = []
    try:
        model = robot_model(robot, None, WHO)
    except ConfigError as error:
        model = None
        findings.append(Finding("MJCF", WRONG, str(error), "mend the file"))
    else:
        rows, of_model = _of_model(robot, model)
        findings += of_model
    if any(one.subject == "frames" and one.state == WRONG for one in findings):
        findings.append(Finding("capsules", WRONG, "not compared", "first make the frames agree"))
    else:
        findings += _of_shape(robot)
    for profile in robot.safety:
        findings.append(_of_gate_file(robot, profile))
    findings += _of_hal(robot, hal)
    return RobotCheck(rows, findings)


def _of_model(
    robot: RobotManifest, model: RobotModel | None
) -> tuple[list[FrameRow], list[Finding]]:
    if model is None:
        fix = (
            f"put it beside robot.yaml as {robot.id}.xml for hal_mujoco; a HAL of your own can "
            "bring the robot's frames instead"
        )
        return [], [Finding("MJCF", OPEN, "none: the URDF is compared with nothing", fix)]
    try:
        errors, _ = frame_errors(robot, model.frames, model.frames.positions(), WHO)
    except ConfigError as error:
        return [], [Finding("frames", WRONG, str(error), "mend simulator in robot.yaml")]
    rows = _frame_rows(errors)
    findings = [_of_frames(robot, rows)]
    if not model.name.startswith(ROBOSUITE):
        problems = model_problems(robot, Path(model.name))
        fix = f"mend {Path(model.name).name}; until then run: hal_kinematic"
        findings += [
            Finding("MJCF", WRONG, one.removeprefix("hal_mujoco: "), fix) for one in problems
        ]
        if not problems:
            findings.append(Finding("MJCF", OK, f"{Path(model.name).name}: hal_mujoco can move it"))
            findings += [Finding("servos", OPEN, *one) for one in servo_findings(robot, model)]
    return rows, findings


def _frame_rows(errors: Sequence[FrameError]) -> list[FrameRow]:
    by_frame: dict[str, list[FrameError]] = {}
    for one in errors:
        by_frame.setdefault(one.frame, []).append(one)
    return [
        FrameRow(
            frame, found[0].distance_m * 1e3, found[0].angle_rad,
            max((one.distance_m * 1e3 for one in found[1:]), default=0.0),
            max((one.angle_rad for one in found[1:]), default=0.0),
        )
        for frame, found in by_frame.items()
    ]  # fmt: skip


def _of_frames(robot: RobotManifest, rows: Sequence[FrameRow]) -> Finding:
    allowed = FrameTolerance() if robot.simulator is None else robot.simulator.frame_tolerance
    off = [
        one.frame
        for one in rows
        if max(one.home_mm, one.random_mm) > allowed.distance_m * 1e3
        or max(one.home_rad, one.random_rad) > allowed.angle_rad
    ]
    if off:
        return Finding(
            "frames", WRONG, f"URDF and MJCF disagree on {', '.join(off)}",
            f"correct {robot.description}, or what simulator in robot.yaml takes for the same",
        )  # fmt: skip
    return Finding("frames", OK, f"URDF and MJCF agree on {len(rows)}")


def _of_shape(robot: RobotManifest) -> Iterator[Finding]:
    again = f"fairlead robot capsules {robot.id}"
    try:
        capsules = load_capsules(robot).capsules
        shape = RobotShape(robot, geometry_source(robot, None))
        problems = shape.uncovered([one for one in capsules if one.link in shape.geometry])
        drawn = drawn_links(robot, shape.source)
    except ConfigError as error:
        yield Finding("capsules", MISSING, str(error), again)
        return
    covered = {one.link for one in capsules}
    swept = {link.name for link in shape.tree.links if is_swept(robot, shape.tree, link)}
    for link in shape.tree.frames:
        if link in covered or link in swept:
            continue
        why, seen = robot.no_collision_geometry.get(link), link in drawn
        has = drawn[link] if seen and link not in shape.geometry else "no capsule"
        fix = f"give it collision geometry in {shape.source.name}, then: {again}"
        if why is None:
            yield Finding("capsules", MISSING, f"{link}: {has}", f"{fix}; or say why it needs none")
        elif seen:
            yield Finding("capsules", OPEN, f"{link}: {has}; declared: {why}", fix)
    yield from (Finding("capsules", WRONG, one, again) for one in problems)
    if not problems:
        yield Finding("capsules", OK, f"{len(capsules)} capsules cover {len(covered)} links")


def _of_gate_file(robot: RobotManifest, profile: str) -> Finding:
    path, again = robot_dir(robot.id) / f"gate.{profile}.json", f"fairlead robot compile {robot.id}"
    try:
        text = compile_gate_config(robot, profile)
    except ConfigError as error:
        return Finding("gate file", WRONG, f"{profile}: {error}", "mend what it names")
    if robot.open_numbers(profile):
        found = f"{profile}: {len(robot.to_confirm)} entries of to_confirm in robot.yaml are open"
        return Finding("gate file", OPEN, found, f"correct each, delete its line, then: {again}")
    if not path.is_file():
        return Finding("gate file", MISSING, f"{path.name} is not there", again)
    if path.read_bytes() != text.encode():
        return Finding("gate file", WRONG, f"{path.name} is of other files than those here", again)
    return Finding("gate file", OK, f"{path.name} is current")


def _of_hal(robot: RobotManifest, hal: HalStatus | None) -> Iterator[Finding]:
    if hal is None:
        yield Finding("HAL", OPEN, "none runs on this machine", "fairlead up, or --deployment FILE")
        return
    parts = {part.name: list(part.joints) for part in robot.parts}
    modes = {part.name: sorted(part.modes) for part in robot.parts}
    compared: tuple[tuple[str, object, object], ...] = (
        ("joints", list(robot.joint_names), list(hal.joints)),
        ("passive joints", list(robot.passive_joint_names), list(hal.passive_joints)),
        ("parts", parts, {one.name: list(one.joints) for one in hal.parts}),
        (
            "modes",
            modes,
            {p.name: sorted(ControlMode(r.mode).yaml_name for r in p.ranges) for p in hal.parts},
        ),
        ("period in ns", robot.tick_period_ns, hal.period_ns),
        ("robot hash", robot.robot_hash.hex(), hal.robot_hash.hex()),
    )
    wrong = [(what, ours, theirs) for what, ours, theirs in compared if ours != theirs]
    for what, ours, theirs in wrong:
        found = f"{what}: robot.yaml has {ours}, the HAL {theirs}"
        yield Finding("HAL", WRONG, found, "mend one of them, then: fairlead restart hal")
    if not wrong:
        yield Finding("HAL", OK, f"joints, parts, modes and period as in robot.yaml ({hal.state})")
