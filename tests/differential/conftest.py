"""One pair of judges per robot, for all tests of a run."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from fairlead.paths import gate_config
from tests.differential.gates import (
    FEW_CHANGES,
    MORE_FRAMES,
    ROBOTS,
    Pair,
    pair_of,
    with_few_changes,
    with_more_frames,
)


@pytest.fixture(scope="session", params=[*ROBOTS, MORE_FRAMES, FEW_CHANGES])
def pair(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Pair]:
    """Each robot in turn, one whose tools may be commanded in several frames, and one that may
    change little."""
    robot, config = request.param, None
    if robot == MORE_FRAMES:
        robot = "dual_panda"
        config = with_more_frames(gate_config(robot, "sim"), tmp_path_factory.mktemp("gate"))
    if robot == FEW_CHANGES:
        robot = "panda_mobile"
        config = with_few_changes(gate_config(robot, "sim"), tmp_path_factory.mktemp("gate"))
    with pair_of(robot, config) as found:
        yield found


@pytest.fixture(scope="session")
def panda() -> Iterator[Pair]:
    """The robot whose cases are computed by hand."""
    with pair_of("panda") as found:
        yield found
