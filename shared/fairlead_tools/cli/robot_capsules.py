"""``fairlead robot capsules``: capsules around a robot's links, and which are kept apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fairlead.errors import ConfigError, expected
from fairlead.paths import robot_dir
from fairlead.robot.capsules import Capsule, load_capsules
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.cli.console import ProgressLine, echo, print_json, print_table
from fairlead_tools.cli.options import JsonOption, RobotArgument, example
from fairlead_tools.record.picture_file import require_picture
from fairlead_tools.shape import SAMPLES
from fairlead_tools.writable import require_writable

if TYPE_CHECKING:
    from fairlead_tools.shape.capsule_pairs import CapsulePair
    from fairlead_tools.shape.robot_shape import RobotShape

LEAST_SAMPLES = 10_000


@example("fairlead robot capsules panda --picture panda.png")
def capsules_command(
    robot: RobotArgument,
    model: Annotated[
        str | None,
        typer.Option(
            help="geometry: an MJCF file, robosuite:ROBOT or robosuite:ROBOT+GRIPPER; else "
            "simulator.model of robot.yaml, else ROBOT.xml beside it, else the <collision> "
            "elements of its URDF"
        ),
    ] = None,
    most_per_link: Annotated[
        int, typer.Option("--max-per-link", min=1, max=8, help="most capsules for one link")
    ] = 3,
    samples: Annotated[
        int, typer.Option(min=LEAST_SAMPLES, help="random poses to look for pairs in")
    ] = SAMPLES,
    drop_margin_m: Annotated[
        float | None,
        typer.Option(
            min=0.0, help="leave out pairs that never come nearer than the clearance and this"
        ),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="draw links and capsules at rest into this PNG file; "
                     "with --check those of capsules.yaml, which stays as it is")
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="write nothing; exit 1 if the file does not cover the geometry or "
            "its pairs are others",
        ),
    ] = False,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Fit capsules to a robot's links and find the pairs to keep apart; write capsules.yaml."""
    from fairlead_tools.shape.capsule_pairs import PairRule
    from fairlead_tools.shape.geometry import geometry_source
    from fairlead_tools.shape.robot_shape import RobotShape

    if picture is not None:
        require_picture("robot capsules --picture", picture)
        require_writable("robot capsules: --picture", picture)
    manifest = load_robot(robot)
    if not check:
        require_writable("robot capsules", robot_dir(robot) / manifest.capsules)
    clearance_m = min(one.self_collision.clearance_m for one in manifest.safety.values())
    most_m = max(one.self_collision.clearance_m for one in manifest.safety.values())
    margin_m = None if drop_margin_m is None else drop_margin_m + most_m - clearance_m
    rule = PairRule(clearance_m, margin_m, samples)  # what is left out is far in every profile
    with ProgressLine(quiet=as_json) as line, line.counting() as say:
        say(f"{robot}: its geometry, and whether its description agrees")
        shape = RobotShape(manifest, geometry_source(manifest, model), say)
        shape.check_bare_links()
        capsules = load_capsules(manifest).capsules if check else shape.fitted(most_per_link)
        pairs = shape.pairs(capsules, rule)
    at_rest = _distances_at_rest(shape, capsules, pairs, clearance_m)
    if as_json:
        print_json(_document(capsules, pairs, at_rest, clearance_m))
    else:
        _print(capsules, pairs, at_rest, shape.source.agreement)
    if picture is not None:
        _draw(shape, capsules, pairs, picture)
        if not as_json:
            echo(f"wrote {picture}")
    if check:
        _check(shape, capsules, pairs, quiet=as_json)
    else:
        asked = _again(robot, model, most_per_link, samples, drop_margin_m)
        _write(manifest, asked, capsules, pairs, quiet=as_json)


def _distances_at_rest(
    shape: RobotShape,
    capsules: Sequence[Capsule],
    pairs: Sequence[CapsulePair],
    clearance_m: float,
) -> Sequence[float]:
    """Of each pair [m]; refused if one to keep apart is nearer than the clearance."""
    at_rest = shape.rest_distances(capsules, pairs)
    for pair, distance in zip(pairs, at_rest, strict=True):
        if not pair.why_not and not distance >= clearance_m:
            links = f"{capsules[pair.first].link} and {capsules[pair.second].link}"
            wanted = f"{links} at least {clearance_m:g} m apart where the robot rests"
            raise ConfigError(
                expected(f"robot capsules: {shape.robot.id}", wanted, f"{distance:.4f} m")
                + "; more capsules (--max-per-link) fit more closely"
            )
    return at_rest


def _print(
    capsules: Sequence[Capsule],
    pairs: Sequence[CapsulePair],
    at_rest: Sequence[float],
    agreement: str,
) -> None:
    print_table(
        ("", "LINK", "A [m]", "B [m]", "RADIUS [m]"),
        [
            (number, one.link, _point(one.a_m), _point(one.b_m), f"{one.radius_m:.4f}")
            for number, one in enumerate(capsules)
        ],
    )
    echo("")
    print_table(
        ("PAIR", "LINKS", "AT REST [m]", "LEAST [m]", "NEAR", "CHECKED"),
        [
            (
                f"{pair.first}-{pair.second}",
                f"{capsules[pair.first].link}, {capsules[pair.second].link}",
                f"{rest:.3f}",
                f"{pair.least_m:.3f}",
                f"{pair.near_share:.1%}",
                f"no: {pair.why_not}" if pair.why_not else "yes",
            )
            for pair, rest in zip(pairs, at_rest, strict=True)
        ],
    )
    checked = sum(not pair.why_not for pair in pairs)
    echo(f"\n{len(capsules)} capsules, {checked} of {len(pairs)} pairs are kept apart")
    echo(agreement)


def _point(point: tuple[float, float, float]) -> str:
    return " ".join(f"{value:7.4f}" for value in point)


def _document(
    capsules: Sequence[Capsule],
    pairs: Sequence[CapsulePair],
    at_rest: Sequence[float],
    clearance_m: float,
) -> dict[str, Any]:
    return {
        "clearance_m": clearance_m,
        "capsules": [one.model_dump() for one in capsules],
        "pairs": [
            {
                "capsules": [pair.first, pair.second],
                "links": [capsules[pair.first].link, capsules[pair.second].link],
                "checked": not pair.why_not,
                "why_not": pair.why_not,
                "at_rest_m": rest,
                "least_m": pair.least_m,
                "near_share": pair.near_share,
            }
            for pair, rest in zip(pairs, at_rest, strict=True)
        ],
    }


def _draw(
    shape: RobotShape, capsules: Sequence[Capsule], pairs: Sequence[CapsulePair], path: Path
) -> None:
    from fairlead_tools.record.capsule_picture import draw_capsules

    checked = sum(not pair.why_not for pair in pairs)
    title = f"{shape.robot.id} at rest: {len(capsules)} capsules, {checked} pairs kept apart"
    try:
        draw_capsules(*shape.drawn(capsules), title, path)
    except OSError as error:
        raise ConfigError(f"robot capsules: cannot write {path}: {error.strerror}") from None


def _check(
    shape: RobotShape,
    capsules: Sequence[Capsule],
    pairs: Sequence[CapsulePair],
    *,
    quiet: bool,
) -> None:
    problems = shape.uncovered(capsules)
    wanted = {(pair.first, pair.second) for pair in pairs if not pair.why_not}
    told = set(load_capsules(shape.robot).checked_pairs)
    problems += [f"pair {list(pair)} should be checked" for pair in sorted(wanted - told)]
    problems += [f"pair {list(pair)} should not be checked" for pair in sorted(told - wanted)]
    for problem in problems:
        echo(f"ERROR {shape.robot.id}: {problem}", err=True)
    if problems:
        raise typer.Exit(1)
    if not quiet:
        path = robot_dir(shape.robot.id) / shape.robot.capsules
        echo(f"{path} covers the geometry, and has the pairs that follow from it")


def _again(
    robot: str, model: str | None, most: int, samples: int, drop_margin_m: float | None
) -> str:
    """The command that makes the same file."""
    words = [f"fairlead robot capsules {robot}"]
    words += [f"--model {model}"] if model else []
    words += [f"--max-per-link {most} --samples {samples}"]
    words += [f"--drop-margin-m {drop_margin_m:g}"] if drop_margin_m is not None else []
    return " ".join(words)


def _write(
    manifest: RobotManifest,
    asked: str,
    capsules: Sequence[Capsule],
    pairs: Sequence[CapsulePair],
    *,
    quiet: bool,
) -> None:
    from fairlead_tools.shape.file_text import file_text

    path = robot_dir(manifest.id) / manifest.capsules
    try:
        path.write_text(file_text(manifest.id, asked, capsules, pairs), encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"robot capsules: cannot write {path}: {error.strerror}") from None
    if not quiet:
        echo(f"wrote {path}; review it, then: fairlead robot compile {manifest.id}")


@example("fairlead robot distances panda_mobile out/demo/state/safety/decisions/000001.decisions")
def distances_command(
    robot: RobotArgument,
    log: Annotated[Path, typer.Argument(help="a run's decision log, or a folder: its newest")],
    as_json: JsonOption = False,
) -> None:
    """Print the smallest distance of each checked pair of capsules over a recorded run."""
    from fairlead.robot.capsule_distance import capsule_spans, pair_distances
    from fairlead.robot.description import description_tree
    from fairlead.robot.link_poses import link_poses
    from fairlead_tools.record.run_log import newest_log
    from fairlead_tools.shape.recorded_positions import recorded_positions

    manifest, newest = load_robot(robot), newest_log(log) if log.is_dir() else log
    file, measured = load_capsules(manifest), recorded_positions(manifest, newest)
    columns = {name: measured[:, i] for i, name in enumerate(manifest.measured_joint_names)}
    spans = capsule_spans(file.capsules, link_poses(description_tree(manifest), columns))
    rows = sorted(
        (float(pair_distances(file.capsules, spans, *pair).min()), *pair)
        for pair in file.checked_pairs
    )
    links = [one.link for one in file.capsules]
    if as_json:
        print_json(
            [
                {"capsules": [i, j], "links": [links[i], links[j]], "least_m": least}
                for least, i, j in rows
            ]
        )
        return
    print_table(
        ("LEAST [m]", "PAIR", "LINKS"),
        [(f"{least:.4f}", f"{i}-{j}", f"{links[i]}, {links[j]}") for least, i, j in rows],
    )
    echo(f"\n{len(rows)} pairs over {len(measured)} recorded states of {robot}")
