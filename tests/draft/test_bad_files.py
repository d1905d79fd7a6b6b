"""Files that are no robot's: one clear error each, and nothing is left behind."""

from __future__ import annotations

import signal

import pytest

from fairlead.paths import robot_dir
from fairlead.robot.manifest import load_robot
from fairlead_tools.draft import new_robot
from tests.cli.command import fairlead_here
from tests.draft.drafting import EXAMPLE, Desk

MJCF, URDF = "arm.xml", "arm.urdf"
NO_MESH = '<mesh name="m" file="gone.obj"/>'


@pytest.mark.parametrize(
    ("files", "words", "said"),
    [
        ({}, [], "expected --mjcf, --urdf or both, got neither"),
        ({}, ["--mjcf", MJCF], "expected an MJCF file, got none at arm.xml"),
        ({}, ["--urdf", URDF], "--urdf: arm.urdf: cannot be read: No such file"),
        ({MJCF: "<mujoco><bro"}, ["--mjcf", MJCF], "--mjcf: arm.xml: cannot be read as XML"),
        ({MJCF: "\xff\xfe"}, ["--mjcf", MJCF], "--mjcf: arm.xml: cannot be read as XML"),
        ({MJCF: "<robot/>"}, ["--mjcf", MJCF], "expected <mujoco>, got <robot>: give it as --urdf"),
        (
            {URDF: "<mujoco/>"},
            ["--urdf", URDF],
            "expected <robot>, got <mujoco>: give it as --mjcf",
        ),
        ({MJCF: "<mujoco><wrong/></mujoco>"}, ["--mjcf", MJCF], "arm.xml: XML Error"),
        ({MJCF: "<mujoco/>"}, ["--mjcf", MJCF], "with hinge or slide joints, got none"),
        ({URDF: "<robot><link name='a'/></robot>"}, ["--urdf", URDF], "can be commanded, got none"),
    ],
)
def test_what_is_no_robot_is_said(
    files: dict[str, str], words: list[str], said: str, desk: Desk
) -> None:
    for name, text in files.items():
        (desk.folder / name).write_bytes(text.encode("latin-1"))
    done = desk.new("mine", *words)
    assert (done.returncode, done.stdout) == (1, "")
    assert said in done.stderr, done.stderr
    assert "Traceback" not in done.stderr
    assert not (desk.robots / "mine").exists()
    assert not (desk.folder / "mine.yaml").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<body name="base">', '<body name="base"><freejoint/>', "a robot stands on a fixed base"),
        ('range="-3 3"/>', 'range="-3 3"/><joint axis="1 0 0"/>', "one joint a body, got 2; nest"),
        ('range="-3 3"/>', 'range="3 -3"/>', "range: expected its lower end first, got 3 -3"),
        ('range="-3 3"/>', 'range="nan 3"/>', "range: expected its lower end first, got nan 3"),
        ('angle="radian"', "", 'ranges of the hinges: expected degrees, for <compiler> has no '
         'angle="radian", got none beyond 3: are these radians?'),
        ("<worldbody>", f"<asset>{NO_MESH}</asset><worldbody>", "gone.obj"),
        ('name="right_finger" class="finger" range="-0.04 0"', 'name="right_finger" class="finger"',
         "joint 'right_finger': lower and upper: expected a range, got none"),
    ],
)  # fmt: skip
def test_a_model_that_is_no_arm_is_said_by_joint_or_file(
    old: str, new: str, said: str, desk: Desk
) -> None:
    done = desk.new("mine", "--mjcf", desk.example((old, new)))
    assert done.returncode == 1
    assert said in done.stderr, done.stderr
    assert not (desk.robots / "mine").exists()


def test_a_servo_too_stiff_for_the_timestep_is_said_before_anything_starts(desk: Desk) -> None:
    model = desk.example(
        ('integrator="implicitfast"', ""),
        ('damping="1" armature="0.05"', ""),
        ('kp="400" kv="25" forcerange="-40 40"', 'kp="400" kv="1000"'),
    )
    done = desk.new("mine", "--mjcf", model)
    assert done.returncode == 0, done.stderr
    assert "hal_mujoco cannot move it yet: hal_mujoco: the simulation diverged at" in done.stdout
    assert not (desk.folder / "MUJOCO_LOG.TXT").exists()
    (wrong,) = desk.findings("mine", "wrong")
    assert "give their joints armature or a lower kp" in wrong[1]
    file = desk.folder / "mine.yaml"
    file.write_text(file.read_text().replace("hal_kinematic}", "hal_mujoco}"))
    measured = fairlead_here("robot", "measure", "mine", state=desk.folder)
    assert "ERROR hal_mujoco: the simulation diverged at" in measured.stderr
    assert "Traceback" not in measured.stderr


def test_an_id_that_is_taken_or_no_name_is_refused_and_so_is_a_deployment_file(desk: Desk) -> None:
    taken = f"there is a robot 'panda' already, in {robot_dir('panda')}; choose another id"
    assert taken in desk.new("panda", "--mjcf", EXAMPLE).stderr
    (desk.robots / "own").mkdir(parents=True)
    taken = f"there is a robot 'own' already, in {desk.robots / 'own'}; choose another id"
    assert taken in desk.new("own", "--mjcf", EXAMPLE).stderr
    assert "robot new: id" in desk.new("a b", "--mjcf", EXAMPLE).stderr
    desk.write("mine.yaml", "")
    assert "mine.yaml exists already" in desk.new("mine", "--mjcf", EXAMPLE).stderr


def test_joints_of_other_names_and_limits_that_are_nothing_are_refused(desk: Desk) -> None:
    panda = robot_dir("panda") / "panda.urdf"
    done = desk.new("mine", "--mjcf", EXAMPLE, "--urdf", panda)
    assert "joint 'panda_joint1' of the URDF: expected one joint of its name" in done.stderr
    assert "or leave out --urdf" in done.stderr
    urdf = desk.write("still.urdf", panda.read_text().replace('velocity="2.175"', 'velocity="0"'))
    done = desk.new("mine", "--urdf", urdf)
    assert "joint 'panda_joint1': limit velocity: expected a number above 0, got '0'" in done.stderr


def arm_of(limit: str = 'lower="-2" upper="2"', origin: str = "0 0 0.1", size: str = "0.05") -> str:
    """A URDF of one joint, with a cylinder and a flange of no name that says so."""
    shape = f'<geometry><cylinder radius="{size}" length="{size}"/></geometry>'
    links = (
        f'<link name="a"/><link name="b"><collision>{shape}</collision></link><link name="end"/>'
    )
    fixed = (
        '<joint name="f" type="fixed"><parent link="b"/><child link="end"/>'
        '<origin xyz="0 0 0.2"/></joint>'
    )
    return (
        f'<robot name="mine">{links}{fixed}<joint name="j" type="revolute"><parent link="a"/>'
        f'<child link="b"/><origin xyz="{origin}"/><axis xyz="0 0 1"/>'
        f'<limit {limit} velocity="1" effort="10"/></joint></robot>'
    )


@pytest.mark.parametrize(
    ("urdf", "said"),
    [
        (
            arm_of(limit='lower="-86" upper="86"'),
            "arm.urdf: joint 'j': limit lower: expected rad, or rad/s, up to 25; a joint without "
            "an end is continuous, got -86: are these degrees?",
        ),
        (
            arm_of(limit='lower="0" upper="50"').replace("revolute", "prismatic"),
            "joint 'j': limit upper: expected m, or m/s, up to 10, got 50: are these mm?",
        ),
        (
            arm_of().replace("revolute", "prismatic").replace('city="1"', 'city="600"'),
            "joint 'j': limit velocity: expected m, or m/s, up to 10, got 600: are these mm?",
        ),
        (
            arm_of(origin="0 0 ${height}"),
            "arm.urdf: expected no xacro, got 0 0 ${height}; xacro is not a URDF yet: run xacro",
        ),
        (arm_of(origin="$(arg xyz)"), "expected no xacro, got $(arg xyz); xacro is not a URDF yet"),
        (
            arm_of().replace(">", ' xmlns:x="http://ros.org/wiki/xacro"><x:include/>', 1),
            "arm.urdf: expected no xacro, got <xacro:include>; xacro is not a URDF yet",
        ),
        (
            arm_of().replace(
                '<joint name="f" type="fixed">',
                '<joint name="j" type="prismatic"><limit lower="0" upper="1" velocity="1"/>',
            ),
            "robot new: --urdf: arm.urdf: joint 'j' is declared 2 times",
        ),
        (
            arm_of(limit="").replace("revolute", "floating"),
            "arm.urdf: joint 'j': type: expected one that turns about, or slides along, one axis, "
            "got 'floating' (valid: revolute, continuous, prismatic, fixed)",
        ),
        (
            arm_of().replace('<parent link="b"/>', '<parent link="bb"/>'),
            "arm.urdf: parent of link 'end': expected a link, got 'bb' (valid: a, b, end)",
        ),
        (
            arm_of().replace('<cylinder radius="0.05" length="0.05"/>', '<mesh filename="m.stl"/>'),
            "arm.urdf: Error: decoder failed for mesh file 'm.stl'",
        ),
        (arm_of(limit=""), "joint 'j': lower and upper: expected a range, got none"),
        (
            arm_of(origin="0 0 70"),
            "joint 'j': origin xyz: expected metres, up to 10, got 0 0 70: are these mm?",
        ),
        (
            arm_of(size="60"),
            "link 'b': its shape: expected metres, at most 2 m to each side, got 67.2 m; of a mesh "
            'in mm: scale="0.001 0.001 0.001"',
        ),
        (
            arm_of().replace(' velocity="1"', ""),
            "arm.urdf: joint 'j': limit velocity: expected a number, got none",
        ),
        ('<robot xmlns:xacro="x"><xacro:a></robot>', "cannot be read as XML"),
    ],
)
def test_other_units_are_asked_about_and_errors_name_the_given_file(
    urdf: str, said: str, desk: Desk
) -> None:
    (desk.folder / URDF).write_text(urdf)
    (desk.folder / "m.stl").write_text("solid m")
    done = desk.new("mine", "--urdf", URDF)
    assert done.returncode == 1
    assert said in done.stderr, done.stderr
    assert "Traceback" not in done.stderr
    assert str(desk.robots) not in done.stderr


def test_the_only_end_of_an_arm_is_its_tool_and_a_person_has_to_confirm_it(desk: Desk) -> None:
    (desk.folder / URDF).write_text(arm_of())
    done = desk.new("mine", "--urdf", URDF)
    assert done.returncode == 0, done.stderr
    text = (desk.robots / "mine" / "robot.yaml").read_text()
    assert "tool_frame: end" in text
    assert "end_effectors.tool_of_arm.tool_frame: chosen by" in text


def test_soft_limits_of_a_urdf_narrow_its_range(desk: Desk) -> None:
    soft = '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="9" k_velocity="1"/>'
    (desk.folder / URDF).write_text(arm_of().replace("<limit", f"{soft}<limit"))
    assert desk.new("mine", "--urdf", URDF).returncode == 0
    joint = load_robot("mine").joint("j")
    assert (joint.lower_rad, joint.upper_rad) == (-0.5, 2.0)


@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGHUP])
def test_a_draft_that_is_ended_leaves_nothing_behind(
    ending: signal.Signals, desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def end(*given: object) -> None:
        assert (desk.robots / "mine" / "mine.urdf").is_file()
        signal.raise_signal(ending)

    monkeypatch.setattr(new_robot, "_written", end)
    before = signal.signal(ending, signal.SIG_IGN)
    try:
        done = desk.new("mine", "--mjcf", EXAMPLE)
    finally:
        signal.signal(ending, before)
    assert done.returncode == 130, done.stderr
    assert not list(desk.robots.iterdir())
