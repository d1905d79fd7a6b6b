"""A gate, a scripted HAL and a scripted runner, on real Zenoh."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from bench.equipment.mailbox import DEADLINE_S, Mailbox
from bench.equipment.running_gate import ROBOT, RunningGate
from bench.equipment.scripted_hal import ScriptedHal
from fairlead.deploy.deployment import Deployment
from fairlead.keys import Keys
from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    Arm,
    ArmReply,
    Claim,
    ClaimReply,
    Disarm,
    Done,
    GateState,
    GateStatus,
    Heartbeat,
    Lease,
    Message,
    Release,
    Reset,
    SafeChunk,
    StatusQuery,
    StopLevel,
    Verdict,
    decode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

SOURCE = "runner"
ARM = 0  # index of the part
DELTA_M = 0.01


def everybody(robot: str, file: Path) -> dict[str, Any]:
    """What closes access for a session with everybody's rights and, in a file, for its gate."""
    kinds = {"hal": "hal_kinematic", "safety": "safety", SOURCE: "skill_runner"}
    services = {name: {"run": run} for name, run in kinds.items()}
    deployment = Deployment.model_validate({"robot": robot, "id": robot, "services": services})
    gate, own = (
        dict(deployment.endpoints("safety").access),
        deployment.tool_endpoints(SOURCE).access,
    )
    rules = gate["access_control"]["rules"]
    turned = {"ingress": ["egress"], "egress": ["ingress"]}
    mirrored = [rule | {"flows": turned[rule["flows"][0]]} for rule in rules]
    allow = [rule["id"] for rule in rules if rule["permission"] == "allow"]
    everything = [{"subjects": ["all"], "rules": allow}]
    subjects = [{"id": "all"}]
    gate["access_control"] |= {"subjects": subjects, "policies": everything}
    own = {**own, "access_control": gate["access_control"] | {"rules": mirrored}}
    file.write_text(json.dumps(gate), encoding="utf-8")
    return own


class Scene:
    """One gate process and everybody it talks to, in one session.

    Args:
        closed: with access control.
        listen: the gate's endpoint; empty: a free port of this host.
    """

    def __init__(
        self,
        config: Path,
        state_dir: Path,
        pacing: Literal["realtime", "lockstep"] = "lockstep",
        robot: str = ROBOT,
        closed: bool = False,
        listen: str = "",
    ) -> None:
        self.robot = robot
        self.keys = Keys(robot)
        self.config = config
        self.state_dir = state_dir
        file = state_dir.with_suffix(".access")
        own = everybody(robot, file) if closed else {}
        options = ("--access", str(file)) if closed else ()
        self.gate = RunningGate(config, state_dir, *options, robot=robot, listen=listen)
        self.gate.wait_line("ready")
        self.bus = ZenohBus(Endpoints(connect=[self.gate.endpoint], access=own))
        self.leases = Mailbox(self.bus, self.keys.lease, Lease)
        self.statuses = Mailbox(self.bus, self.keys.gate_status, GateStatus)
        self.verdicts = Mailbox(self.bus, self.keys.verdict(SOURCE), Verdict)
        self.safe = Mailbox(self.bus, self.keys.safe(SOURCE), SafeChunk)
        self.hal = ScriptedHal(self.bus, config, pacing=pacing, robot=robot)
        self._candidates = self.bus.publisher(self.keys.candidate(SOURCE), ActionChunk, Qos.HOT)
        self._heartbeats = self.bus.publisher(self.keys.heartbeat(SOURCE), Heartbeat, Qos.HOT)
        self._stops = self.bus.publisher(self.keys.stop, StopLevel, Qos.HOT)
        self.claim_id = 0
        self.epoch = 0
        self.seq = 0
        self._alive = threading.Event()
        self._quiet = threading.Event()
        self._heart: threading.Thread | None = None
        self.bus.watch_tokens(self.keys.alive("safety"), self._on_token)
        self.wait_alive()

    def _on_token(self, key: str, alive: bool) -> None:
        (self._alive.set if alive else self._alive.clear)()

    def wait_alive(self) -> None:
        """Until the gate's token, and so all it listens to, is known here."""
        assert self._alive.wait(DEADLINE_S), "no liveliness token of the gate"

    def restart_gate(self) -> None:
        """Start the gate again on the same port and state folder."""
        self._alive.clear()
        self.gate = RunningGate(self.config, self.state_dir, robot=self.robot, port=self.gate.port)
        self.gate.wait_line("ready")
        self.wait_alive()
        self.leases.skip()
        self.statuses.skip()

    def close(self) -> None:
        """End the heartbeat."""
        self._quiet.set()
        if self._heart is not None:
            self._heart.join(DEADLINE_S)
        self.gate.close()
        self.bus.close()

    @property
    def ramp_ticks(self) -> int:
        """Ticks after which a part that was told to stop has to be seen at standstill."""
        file = json.loads(self.config.read_text())
        ramp_ns, period_ns = file["protocol"]["stop_ramp_ms"] * 1e6, int(file["period_ns"])
        return math.ceil(float(ramp_ns) / period_ns)

    # --- HAL ---

    def meet_hal(self) -> None:
        """The gate has seen the HAL's status and first state."""
        self.hal.publish_status()
        self.leases.wait_for(lambda m: m.session == self.hal.session)
        tick = self.hal.publish_state()
        self.leases.wait_for(lambda m: m.state_tick == tick and m.session == self.hal.session)

    def next_tick(self, *args: Any) -> int:
        """Publish the next state and wait until the gate leases it."""
        tick = self.hal.publish_state(*args)
        self.leases.wait_for(lambda m: m.state_tick == tick)
        return tick

    # --- queries ---

    def ask(self, key: str, request: Message) -> bytes:
        """Put a query on a key; the reply's bytes."""
        return self.bus.query(key, request, DEADLINE_S)

    def arm(self) -> ArmReply:
        """Arm; chunks and claims are of its epoch from then on."""
        reply = decode(ArmReply, self.ask(self.keys.gate_command("arm"), Arm(by="test")))
        self.epoch = reply.epoch
        return reply

    def disarm(self) -> Done:
        """Disarm."""
        return decode(Done, self.ask(self.keys.gate_command("disarm"), Disarm(by="test")))

    def reset(self, cited_id: int) -> Done:
        """Reset the stop of that id."""
        request = Reset(by="test", id=cited_id)
        return decode(Done, self.ask(self.keys.gate_command("reset"), request))

    def status(self) -> GateStatus:
        """Ask for the gate's status."""
        return decode(GateStatus, self.ask(self.keys.gate_status, StatusQuery()))

    def wait_state(self, state: GateState) -> GateStatus:
        """Wait until the gate says that it is in a state."""
        return self.statuses.wait_for(lambda m: m.state == state)

    def claim_request(self, *parts: str, **changes: Any) -> Claim:
        """A good claim of parts of the robot, by default of the arm."""
        fields: dict[str, Any] = {
            "source": SOURCE,
            "skill": "test",
            "skill_hash": bytes(range(32)),
            "robot_hash": self.hal.robot_hash,
            "period_ns": self.hal.period_ns,
            "parts": parts or ("arm",),
            "chunk_rate_hz": 20.0,
            "horizon_max": 64,
            "age_max_ticks": 10,
            "limits": (),
        }
        return Claim(**(fields | changes))

    def claim(self, *parts: str, **changes: Any) -> ClaimReply:
        """Claim parts of the robot, the arm by default."""
        request = self.claim_request(*parts, **changes)
        return decode(ClaimReply, self.ask(self.keys.claim(request.source), request))

    def take_claim(self, *parts: str) -> ClaimReply:
        """Claim as the runner does: with a heartbeat from then on."""
        reply = self.claim(*parts)
        self.claim_id = reply.claim_id
        self.seq = 0
        self._heart = threading.Thread(target=self._beat, args=(reply.claim_id,))
        self._heart.start()
        return reply

    def _beat(self, claim_id: int) -> None:
        while not self._quiet.wait(0.05):
            self._heartbeats.put(Heartbeat(claim_id=claim_id))

    def silence(self) -> None:
        """The runner's heartbeat ends."""
        self._quiet.set()

    def release(self) -> Done:
        """Give the live claim back."""
        return self.release_of(SOURCE, self.claim_id)

    def release_of(self, source: str, claim_id: int) -> Done:
        """Give any claim back."""
        request = Release(source=source, claim_id=claim_id)
        return decode(Done, self.ask(self.keys.release(source), request))

    def ready_to_move(self) -> None:
        """HAL met, armed, the arm claimed."""
        self.meet_hal()
        self.arm()
        self.take_claim()

    # --- chunks and stops ---

    def arm_part(self, rows: int = 8, **changes: Any) -> ActionPart:
        """Small steps of the arm along x."""
        values = np.zeros((rows, 6))
        values[:, 0] = DELTA_M
        fields: dict[str, Any] = {
            "part": ARM,
            "mode": ControlMode.CARTESIAN_DELTA,
            "frame_id": "base_link",
            "values": pack_floats(values),
            "active": (),
        }
        return ActionPart(**(fields | changes))

    def chunk(self, rows: int = 8, **changes: Any) -> ActionChunk:
        """A good chunk for the newest tick, with the next sequence number."""
        self.seq += 1
        fields: dict[str, Any] = {
            "robot_hash": self.hal.robot_hash,
            "session": self.hal.session,
            "epoch": self.epoch,
            "claim_id": self.claim_id,
            "source": SOURCE,
            "seq": self.seq,
            "goal_id": 1,
            "obs_tick": self.hal.tick,
            "oldest_tick": self.hal.tick,
            "start_tick": self.hal.tick,
            "horizon": rows,
            "parts": (self.arm_part(rows),),
            "trace": NO_TRACE,
        }
        return ActionChunk(**(fields | changes))

    def send(self, chunk: ActionChunk) -> Verdict:
        """Publish a chunk and wait for the gate's answer to it."""
        self._candidates.put(chunk)
        return self.verdicts.wait_for(lambda m: m.seq == chunk.seq)

    def send_bytes(self, payload: bytes) -> None:
        """Put any bytes on the key for the runner's chunks."""
        self._candidates.put_bytes(payload)

    def raise_stop(self, stop_id: int) -> None:
        """An operator's stop, once: the caller repeats it if it must."""
        self._stops.put(StopLevel(stop_id=stop_id, by="operator", reason="test"))

    def acted_on(self, verdict: Verdict, row: int, parts: Sequence[str] = ("arm",)) -> int:
        """The HAL executed a released row; returns the next tick."""
        return self.next_tick(self.hal.executed(verdict.verdict_id, row, parts))
