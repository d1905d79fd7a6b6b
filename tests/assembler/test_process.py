"""The service as a real process on a real Zenoh session."""

import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
import yaml

from fairlead.keys import Keys
from fairlead.messages import JointState, LayoutState, TransformBatch, decode
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import SkillView
from fairlead_tools.supervisor.this_host import free_ports
from tests.assembler.robot_feed import SKILL, RobotFeed, layouts

pytestmark = pytest.mark.processes

KEYS = Keys("panda_mobile")
DEADLINE_S = 20.0


def deployment_file(folder: Path, **options: object) -> tuple[Path, str]:
    endpoint, ours = (f"tcp/127.0.0.1:{port}" for port in free_ports(2))
    path = folder / "deployment.yaml"
    service = {"run": "state_assembler", "listen": endpoint, "options": options}
    hal = {"run": "hal_sim", "listen": ours}  # this test itself
    content = {
        "robot": "panda_mobile",
        "id": "panda_mobile",
        "access": "open",  # one session is everybody but the assembler
        "services": {"state_assembler": service, "hal": hal},
    }
    path.write_text(yaml.safe_dump(content))
    return path, endpoint


def start(path: Path, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [
            *(sys.executable, "-m", "fairlead_state_assembler"),
            *("--deployment", str(path), "--service", "state_assembler"),
            *("--state-dir", str(folder / "state")),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


class World:
    """A session beside one running service: what the HAL and a tracker would send."""

    def __init__(self, endpoint: str) -> None:
        self.bus = ZenohBus(Endpoints(connect=[endpoint]))
        self._states: list[LayoutState] = []
        self._answered, alive = threading.Event(), threading.Event()
        token = KEYS.alive("state_assembler")
        self.bus.watch_tokens(token, lambda _, on: alive.set() if on else None)
        assert alive.wait(DEADLINE_S), "the assembler did not come up"
        self.bus.subscribe(KEYS.layout(SKILL), self._on_layout)
        self._tf = self.bus.publisher(KEYS.tf("hal"), TransformBatch, Qos.HOT)
        self._tracker = self.bus.publisher(KEYS.tf("tracker"), TransformBatch, Qos.HOT)
        self._joints = self.bus.publisher(KEYS.joints, JointState, Qos.HOT)
        self.bus.declare_token(KEYS.want_layout(SKILL))

    def _on_layout(self, sample: Sample) -> None:
        self._states.append(decode(LayoutState, sample.payload))
        self._answered.set()

    def first_answer(
        self, feed: RobotFeed, tick: int, by_tracker: Sequence[TransformBatch]
    ) -> LayoutState:
        """Send a tick again and again until it is answered."""
        for _ in range(int(DEADLINE_S / 0.1)):
            self._tf.put(feed.static(tick))
            self._tf.put(feed.moving(tick, "base_link", "goal"))
            for batch in by_tracker:
                self._tracker.put(batch)
            self._joints.put(feed.joints(tick))
            if self._answered.wait(0.1):
                return next((s for s in self._states if s.fault is None), self._states[0])
        raise AssertionError("no layout")


@contextmanager
def service(path: Path, folder: Path, *, kill: bool = False) -> Iterator[None]:
    """The process for a moment; killed in the end, or asked to end."""
    process = start(path, folder)
    try:
        yield
    finally:
        if kill:
            process.kill()
        else:
            process.terminate()
        output, _ = process.communicate(timeout=DEADLINE_S)
    assert kill or process.returncode == 0, output


def test_layout_follows_over_zenoh_and_after_a_kill_comes_from_the_hal_of_now_alone(
    tmp_path: Path, feed: RobotFeed, robot: RobotManifest
) -> None:
    path, endpoint = deployment_file(tmp_path)
    with service(path, tmp_path, kill=True):
        world = World(endpoint)
        state = world.first_answer(feed, 1, [feed.moving(1, "object")])
        assert (state.tick, state.skill, state.fault) == (1, SKILL, None)
        world.bus.close()
    core = AssemblerCore(robot, Publishers())
    core.want(SkillView(SKILL))
    core.on_transforms(feed.static(2), "hal")
    core.on_transforms(feed.moving(2), "hal")
    [wanted] = layouts(core.on_joints(feed.joints(2)))
    gone = RobotFeed(robot, session=3)  # the tracker goes on with what a dead HAL told it
    with service(path, tmp_path):
        world = World(endpoint)
        batches = [gone.moving(900, "object"), feed.moving(2, "object")]
        assert world.first_answer(feed, 2, batches) == wanted
        world.bus.close()


def test_unknown_option_ends_the_process_with_one_line(tmp_path: Path) -> None:
    path, _ = deployment_file(tmp_path, max_age=1)
    process = start(path, tmp_path)
    output, _ = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 1
    assert output.partition(" ")[2] == (
        "ERROR fairlead-state-assembler: service state_assembler: options: 1 problem(s):\n"
        f"  {path}:11:7: max_age: unknown key, did you mean max_age_ticks? (valid: max_age_ticks)\n"
    )
