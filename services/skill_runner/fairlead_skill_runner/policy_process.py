"""The policy's own process: ``python -m fairlead_skill_runner.policy_process FD``.

A policy that keeps the interpreter busy, leaks or crashes does so here; the runner's
heartbeats come from another process. It ends with its runner.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
import threading
import traceback

from fairlead.errors import FairleadError, PolicyError
from fairlead.policy import Done, Failed, Policy
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policies.backends import make_policy
from fairlead_skill_runner.policy_wire import (
    HEADER,
    Answer,
    Ended,
    Infer,
    Load,
    Raised,
    Reply,
    Request,
    Reset,
    decode_request,
    encode,
    pack_actions,
)

_PARENT_CHECK_S = 0.5


def main() -> int:
    """Answer requests until the runner closes its end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the runner, which ends us
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    pipe = socket.socket(fileno=int(sys.argv[1])).makefile("rwb")
    policy: Policy | None = None
    while header := pipe.read(HEADER.size):
        request = decode_request(pipe.read(*HEADER.unpack(header)))
        try:
            if isinstance(request, Load):
                policy = _load(request)
                reply: Reply = Answer()
            else:
                reply = _answer(policy, request)
        except FairleadError as error:
            reply = Raised(str(error))
        except Exception as error:  # noqa: BLE001 - whatever a policy raises is its answer
            traceback.print_exc()
            reply = Raised(f"{type(error).__name__}: {error}")
        message = encode(reply)
        pipe.write(HEADER.pack(len(message)) + message)
        pipe.flush()
    return 0


def _end_with(parent: int) -> None:
    """A policy that hangs must not outlive a runner that was killed."""
    waiting = threading.Event()
    while not waiting.wait(_PARENT_CHECK_S):
        if os.getppid() != parent:
            os._exit(1)


def _load(request: Load) -> Policy:
    skill = SkillManifest.model_validate_json(request.skill)
    options = json.loads(request.options)
    return make_policy(
        request.policy, skill, options, lambda: load_robot(request.robot), request.profile
    )


def _answer(policy: Policy | None, request: Request) -> Reply:
    if policy is None:
        raise PolicyError("policy worker: asked before a policy was loaded")
    if isinstance(request, Infer):
        said = policy.infer(request.observation())
        return Ended.of(said) if isinstance(said, Done | Failed) else pack_actions(said)
    assert isinstance(request, Reset)
    policy.reset()
    return Answer()


if __name__ == "__main__":
    raise SystemExit(main())
