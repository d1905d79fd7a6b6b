"""Who speaks in another's name to the gate: nothing moves, and status and log say why."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.gate_scene import SOURCE, Scene
from fairlead.errors import FairleadError, RefusedError
from fairlead.keys import of_person
from fairlead.messages import Acted, Arm, Claim, GateState, Heartbeat, Release, Reset
from fairlead.robot.gate_file import sealed
from fairlead.wire.bus import Qos

pytestmark = pytest.mark.processes

OTHER = "planner"


def refused_on_another_key(scene: Scene, key: str, request: Claim | Release) -> None:
    with pytest.raises(RefusedError) as refusal:
        scene.ask(key, request)
    said = f"asked in the name of {SOURCE} on the key of {OTHER}"
    assert refusal.value.reason == said
    scene.gate.wait_line(f"refused a query: {said}")


def test_nobody_claims_or_releases_in_the_name_of_another_than_the_keys(scene: Scene) -> None:
    scene.meet_hal()
    scene.arm()
    refused_on_another_key(scene, scene.keys.claim(OTHER), scene.claim_request())
    scene.take_claim()
    theirs = Release(source=SOURCE, claim_id=scene.claim_id, offered_to=OTHER)
    refused_on_another_key(scene, scene.keys.release(OTHER), theirs)
    assert [claim.source for claim in scene.status().claims] == [SOURCE]
    scene.release()
    scene.claim(source=OTHER)


def test_a_command_on_a_persons_key_is_that_persons_alone(scene: Scene) -> None:
    scene.meet_hal()
    arm = scene.keys.gate_command("arm")
    for owner, named in (("ben", "ada"), ("*", "ada"), ("ada", "adam")):
        said = f"asked in the name of {named} on the key of {owner}"
        with pytest.raises(RefusedError, match=re.escape(said)):
            scene.ask(of_person(arm, owner), Arm(by=f"{named}@lab (x)"))
        scene.gate.wait_line(f"refused a query: {said}")
    assert scene.status().state == GateState.DISARMED
    scene.ask(of_person(arm, "ada"), Arm(by="ada@lab (x)"))
    scene.gate.wait_line("armed by ada@lab (x)")


@pytest.mark.parametrize("key", ["**", "fl/**", "*/*/**"])
def test_a_key_of_wildcards_alone_ends_no_gate(scene: Scene, key: str) -> None:
    scene.meet_hal()
    for message in (Heartbeat(claim_id=1), Arm(by="ada@lab (x)")):
        scene.bus.publisher(key, type(message), Qos.HOT).put(message)
    with pytest.raises(FairleadError):
        scene.ask(key, Release(source=SOURCE, claim_id=1))
    assert scene.status().state != GateState.ARMED, "it answers still"


def test_a_second_state_of_a_tick_stops_and_names_two_hals(scene: Scene) -> None:
    scene.ready_to_move()
    scene.hal.repeat_state()  # the same once more is the HAL's own
    scene.next_tick()
    assert scene.status().state == GateState.ARMED
    scene.hal.positions += 1e-6
    scene.hal.repeat_state()
    cause = scene.wait_state(GateState.STOPPED).cause
    assert cause.startswith("stopped: two HALs publish for this robot: a second state of tick ")
    scene.gate.wait_line(cause)


def test_a_row_that_acted_without_the_gate_latches_and_names_two_gates(scene: Scene) -> None:
    scene.ready_to_move()
    verdict = scene.send(scene.chunk())
    scene.acted_on(verdict, 0)
    assert scene.status().state == GateState.ARMED
    forged = Acted(hold=0, verdict_id=verdict.verdict_id + 9, row=0)
    scene.hal.publish_state([forged, *scene.hal.held()[1:]])
    cause = scene.wait_state(GateState.LATCHED).cause
    assert cause == (
        f"latched: two gates serve this robot: arm executed row 0 of verdict {forged.verdict_id}, "
        "which this one did not release"
    )
    scene.gate.wait_line(cause)


@pytest.fixture
def careful_scene(config: Path, tmp_path: Path) -> Iterator[Scene]:
    """A gate whose latch two persons have to reset."""
    file = json.loads(config.read_text())
    file["protocol"]["second_person_s"] = 60
    careful = tmp_path / "careful.json"
    careful.write_text(sealed(json.dumps(file)))
    scene = Scene(careful, tmp_path / "gate")
    yield scene
    scene.close()


def test_a_latch_that_two_persons_have_to_reset_names_the_first_and_waits(
    careful_scene: Scene,
) -> None:
    scene = careful_scene
    scene.ready_to_move()
    forged = Acted(hold=0, verdict_id=1, row=0)
    scene.hal.publish_state([forged, *scene.hal.held()[1:]])
    latch_id = scene.wait_state(GateState.LATCHED).latch_id
    for _ in range(12):
        scene.next_tick(scene.hal.held())
    key = scene.keys.gate_command("reset")
    said = "ada@lab (fairlead) asked to reset the latch; another person has to ask too, within 60 s"
    for _ in range(2):
        with pytest.raises(RefusedError) as refusal:
            scene.ask(key, Reset(by="ada@lab (fairlead)", id=latch_id))
        assert refusal.value.reason == said
    scene.gate.wait_line(f"refused a query: {said}")
    assert scene.status().state == GateState.LATCHED
    scene.ask(key, Reset(by="ben@lab (fairlead)", id=latch_id))
    scene.gate.wait_line("was reset by ada@lab (fairlead) and ben@lab (fairlead)")
    assert scene.wait_state(GateState.DISARMED).latch_id == 0
