"""Files a person gets wrong: each is refused in one error that names file and place."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import ROBOTS_VARIABLE, robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot

Spoil = Callable[[bytes], bytes]
YAML, URDF, CAPSULES = "robot.yaml", "probe.urdf", "capsules.yaml"
SPEED = "    velocity_rad_s: 2.175\n"
RANGE = "    lower_rad: -2.8973\n    upper_rad: 2.8973\n"
END = "</robot>"
LIMIT = '<limit lower="-2.8973" upper="2.8973" effort="87" velocity="2.175"/>'


def swap(old: str, new: str, count: int = 1) -> Spoil:
    def change(text: bytes) -> bytes:
        assert old.encode() in text, old
        return text.replace(old.encode(), new.encode("utf-8", "surrogatepass"), count)

    return change


def becomes(data: bytes) -> Spoil:
    return lambda _: data


def speed(value: str) -> Spoil:
    return swap(SPEED, f"    velocity_rad_s: {value}\n")


def fixed(name: str, parent: str, child: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="fixed">{ends}</joint>'


def in_links(text: str) -> Spoil:
    return swap(END, text + END)


BAD: dict[str, tuple[str, Spoil, str]] = {
    # YAML
    "true for a number": (YAML, speed("true"), "velocity_rad_s: expected a number, got True"),
    "on for a number": (YAML, speed("on"), "velocity_rad_s: Input should be a valid number"),
    "true in a list": (YAML, swap("gain: [0.5, 1.0]", "gain: [0.5, true]"),
                       "joint_velocity.gain.1: expected a number, got True"),
    "true for a count": (YAML, swap("horizon_max: 64", "horizon_max: true"),
                         "protocol.horizon_max: expected a number, got True"),
    "1 for true": (YAML, swap("lockstep_allowed: true", "lockstep_allowed: 1"),
                   "sim.lockstep_allowed: expected true or false, got 1"),
    "octal": (YAML, speed("010"), "velocity_rad_s: expected a number, got '010'"),
    "base 60": (YAML, speed("1:30"), "velocity_rad_s: Input should be a valid number"),
    "hexadecimal": (YAML, speed("0x2"), "velocity_rad_s: Input should be a valid number"),
    "in quotes": (YAML, speed("'2.1'"), "velocity_rad_s: expected a number, got '2.1'"),
    "with a unit": (YAML, speed("124 deg"), "velocity_rad_s: Input should be a valid number"),
    "1e400": (YAML, speed("1e400"), "velocity_rad_s is not finite"),
    "1e300": (YAML, speed("1e300"), "expected velocity_rad_s up to 1e+06, got 1e+300"),
    "tag of another kind": (YAML, speed("!!int abc"), "a tag that its value is not: "),
    "tag of a program": (YAML, speed("!!python/object/apply:os.getpid []"), "could not determine"),
    "a list as key": (YAML, swap("id: probe\n", "id: probe\n[1, 2]: 3\n"),
                      "not valid YAML: expected a word as key"),
    "merge key": (YAML, swap("panda_joint2: *proximal", "panda_joint2: {<<: *proximal}"),
                  "not valid YAML: merge keys (<<) are not taken"),
    "key twice": (YAML, swap("horizon_max: 64\n", "horizon_max: 64\n      horizon_max: 32\n"),
                  "key 'horizon_max' is given twice"),
    "brackets without end": (YAML, becomes(b"a: " + b"[" * 9000), "brackets within brackets"),
    "braces without end": (YAML, becomes(b"{a: " * 9000), "not valid YAML: brackets within"),
    "empty": (YAML, becomes(b""), "expected `key: value` lines, got nothing"),
    "no text": (YAML, becomes(b"\xff\xfe\x00"), "not a text file in UTF-8"),
    "two documents": (YAML, lambda text: text + b"\n---\na: 1\n", "expected a single document"),
    # numbers that fit nothing
    "range in degrees": (YAML, swap(RANGE, "    lower_rad: -166\n    upper_rad: 166\n"),
                         "joint 'panda_joint1': expected lower in robot.yaml within the "
                         "description's, -2.8973, got -166"),
    "period in seconds": (YAML, swap("period_ms: 50", "period_ms: 0.05"), "greater than or equal"),
    "tolerance of everything": (YAML, swap("tolerance: 0.05", "tolerance: 100"),
                                "expected tolerance up to the joint's whole range, 5.7946"),
    "jump of everything": (YAML, swap("per_tick: 0.22", "per_tick: 22"),
                           "expected jump_per_tick up to the joint's whole range, 5.7946, got 22"),
    "never still": (YAML, swap("standstill_per_s: 0.02", "standstill_per_s: 2.175"),
                    "expected standstill_per_s below the joint's velocity limit, 2.175, got 2.175"),
    "dead band of everything": (YAML, swap("dead_band_per_tick: 0.01", "dead_band_per_tick: 10"),
                                "expected dead_band_per_tick up to the joint's whole range"),
    "tracking of everything": (YAML, swap("tracking_limits: [0.32", "tracking_limits: [4.36"),
                               "joint_velocity: expected tracking_limits of 'panda_joint1' up to "
                               "4.35, from one end to the other, got 4.36"),
    "step of everything": (YAML, swap("step_limits: [0.055", "step_limits: [5.8"),
                           "joint_position: expected step_limits of 'panda_joint1' up to 5.7946"),
    "stroke of everything": (YAML, swap("step_limit_m: 0.08", "step_limit_m: 80"),
                             "expected step_limit_m up to the whole stroke, 0.08, got 80"),
    "volume in mm": (YAML, swap("upper_m: [0.9, 0.8, 1.25]", "upper_m: [900, 800, 1250]"),
                     "volumes.0.upper_m.0: Input should be less than or equal to 100"),
    "clearance in mm": (YAML, swap("clearance_m: 0.01", "clearance_m: 10"),
                        "self_collision.clearance_m: Input should be less than or equal to 1"),
    "a day of silence": (YAML, swap("realtime_ms: 300", "realtime_ms: 86400000"),
                         "heartbeat_timeout_realtime_ms: Input should be less than or"),
    "leases too seldom": (YAML, swap("lease_interval_ms: 25", "lease_interval_ms: 75"),
                          "lease_interval_ms: Input should be less than or equal to 50"),
    # names, sources, files
    "no source": (YAML, swap("source: own choice, more than encoders and capsules are off",
                             "source: ' '"), "self_collision.source: expected where the numbers"),
    "source of a joint": (YAML, swap("&arm_source Franka Emika Panda datasheet (FCI limits)",
                                     "&arm_source ''"), "source: expected words, got ''"),
    "source on two lines": (YAML, swap("source: own choice, more", 'source: "a\\nb" #'),
                            "collision.source: expected text that can be printed"),
    "part without a name": (YAML, lambda text: swap("      arm:\n", "      '':\n")(
        swap("- name: arm\n", "- name: ''\n")(text)), "joints[0].part: expected a name of 1 to 64"),
    "name on two lines": (YAML, swap("- name: reach", '- name: "a\\nb"'),
                          "volumes[0].name: expected a name of 1 to 64 bytes that can be"),
    "mode twice": (YAML, swap("modes: [joint_position, joint_velocity]",
                              "modes: [joint_position, joint_velocity, joint_velocity]"),
                   "modes: expected each once"),
    "description elsewhere": (YAML, swap("probe.urdf", "../panda/panda.urdf"),
                              "description: expected a file in the robot's folder"),
    "capsules elsewhere": (YAML, swap("capsules: capsules.yaml", "capsules: /tmp/capsules.yaml"),
                           "capsules: expected a file in the robot's folder"),
    # URDF
    "loop": (URDF, in_links(fixed("loop", "panda_link3", "panda_link1")),
             "link 'panda_link1' hangs on 2 joints, expected one"),
    "loop apart": (URDF, in_links('<link name="a"/><link name="b"/>' + fixed("1", "a", "b")
                                  + fixed("2", "b", "a")), "links that do not hang on the root"),
    "link twice": (URDF, in_links('<link name="panda_link3"/>'),
                   "link 'panda_link3' is declared 2 times"),
    "joint twice": (URDF, in_links('<link name="a"/>' + fixed("panda_joint1", "panda_link3", "a")),
                    "joint 'panda_joint1' is declared 2 times"),
    "link nobody declared": (URDF, in_links(fixed("f", "panda_link3", "ghost")),
                             "child: expected a link, got 'ghost'"),
    "joint that is gone": (URDF, swap('"panda_joint1" type="revolute"', '"j" type="fixed"'),
                           "joint 'panda_joint1': expected one that moves a link, as its role arm, "
                           "got none"),
    "joint that is fixed": (URDF, swap('name="panda_joint1" type="revolute"',
                                       'name="panda_joint1" type="fixed"'), "got a fixed one"),
    "commanded mimic": (URDF, swap(LIMIT, LIMIT + '<mimic joint="panda_joint3"/>'),
                        "robot.yaml commands it, and it mimics another joint"),
    "tighter there": (URDF, swap(LIMIT, LIMIT.replace("-2.8973", "-1")),
                      "expected lower in robot.yaml within the description's, -1, got -2.8973"),
    "an end left out": (URDF, swap(LIMIT, LIMIT.replace('lower="-2.8973"', "")),
                        "expected lower in robot.yaml within the description's, 0, got -2.8973"),
    "slower there": (URDF, swap(LIMIT, LIMIT.replace("2.175", "0.5")),
                     "expected velocity in robot.yaml within the description's, 0.5, got 2.175"),
    "limit that is none": (URDF, swap(LIMIT, LIMIT.replace("87", "nan")),
                           "limit effort: expected a number, got 'nan'"),
    "origin in mm": (URDF, swap('xyz="0 0 0.333"', 'xyz="0 0 333"'),
                     "xyz: expected metres, at most 100, got '0 0 333'"),
    "too many links": (URDF, in_links("".join(f'<link name="x{i}"/>' + fixed(f"x{i}", "panda_hand",
                       f"x{i}") for i in range(60))), "kinematics.links: expected at most 63, got"),
    "a chain without end": (URDF, in_links("".join(f'<link name="x{i}"/>' + fixed(
        f"x{i}", f"x{i - 1}" if i else "panda_hand", f"x{i}") for i in range(1500))),
        "kinematics.links: expected at most 63, got"),
    "no encoding": (URDF, becomes(b'<?xml version="1.0" encoding="bogus"?><robot/>'),
                    "cannot be read as XML: unknown encoding"),
    "entities of entities": (URDF, becomes(b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + b"".join(
        b'<!ENTITY %c "%s">' % (98 + i, b"&%c;" % (97 + i) * 10) for i in range(9))
        + b']><robot name="&j;"/>'), "cannot be read as XML"),
    # capsules
    "true for a radius": (CAPSULES, lambda text: re.sub(rb"(radius_m:) [\d.]+", rb"\1 true", text),
                          "capsules.0.radius_m: expected a number, got True"),
    "radius in mm": (CAPSULES, lambda text: re.sub(rb"radius_m: [\d.]+", b"radius_m: 60", text),
                     "capsules.0.radius_m: Input should be less than or equal to 10"),
    "pair of false": (CAPSULES, lambda text: re.sub(rb"- \[0, ", b"- [false, ", text),
                      "checked_pairs.0.0: expected a number, got False"),
    "no reason why": (CAPSULES, lambda text: re.sub(rb"why: .*", b"why: ' '", text), "why: "),
}  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot of the user's own: a copy of panda."""
    monkeypatch.setenv(ROBOTS_VARIABLE, str(tmp_path))
    shutil.copytree(robot_dir("panda"), tmp_path / "probe")
    (tmp_path / "probe" / "panda.urdf").rename(tmp_path / "probe" / URDF)
    manifest = tmp_path / "probe" / YAML
    text = manifest.read_text(encoding="utf-8").replace("id: panda\n", "id: probe\n")
    manifest.write_text(text.replace("panda.urdf", URDF), encoding="utf-8")
    return tmp_path / "probe"


def test_the_copy_itself_is_good(folder: Path) -> None:
    assert '"robot": "probe"' in compile_gate_config(load_robot("probe"), "sim")


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_refused_by_name(folder: Path, name: str) -> None:
    file, spoil, wanted = BAD[name]
    (folder / file).write_bytes(spoil((folder / file).read_bytes()))
    with pytest.raises(ConfigError) as error:
        compile_gate_config(load_robot("probe"), "sim")
    assert wanted in str(error.value)
    assert "probe" in str(error.value)


@pytest.mark.parametrize("spoil", [
    lambda text: b"\xef\xbb\xbf" + text,
    lambda text: text.replace(b"\n", b"\r\n"),
    speed("1.5e0"),
    speed("2"),
    swap("source: own choice, more than encoders and capsules are off", "source: 2026-11-22"),
], ids=["byte order mark", "CRLF", "exponent", "whole number", "a date as source"])  # fmt: skip
def test_what_only_looks_odd_is_taken(folder: Path, spoil: Spoil) -> None:
    (folder / YAML).write_bytes(spoil((folder / YAML).read_bytes()))
    assert compile_gate_config(load_robot("probe"), "sim")
