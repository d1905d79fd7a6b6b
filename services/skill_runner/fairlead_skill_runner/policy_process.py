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
from contextlib import suppress
from typing import NamedTuple

from fairlead.checked_model import MisfitError
from fairlead.deploy.scheduling import run_as_ordinary_process
from fairlead.errors import FairleadError, PolicyError
from fairlead.policy import Done, Failed, Policy
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest, locate_in_skill, of_options
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
    run_as_ordinary_process()
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    pipe = socket.socket(fileno=_own(int(sys.argv[1]))).makefile("rwb")
    loaded: _Loaded | None = None
    while header := pipe.read(HEADER.size):
        request = decode_request(pipe.read(*HEADER.unpack(header)))
        try:
            if isinstance(request, Load):
                loaded = _load(request)
                message = encode(Answer())
            else:
                message = encode(_answer(loaded, request))
        except BaseException as error:  # noqa: BLE001 - whatever a policy raises is its answer
            if not isinstance(error, FairleadError) or error.__cause__ is not None:  # its own file
                with suppress(OSError, ValueError):  # a policy may have closed standard error
                    traceback.print_exc()
            message = encode(Raised.of(error))
        pipe.write(HEADER.pack(len(message)) + message)
        pipe.flush()
    return 0


def _own(runner: int) -> int:
    """The runner's socket, for this process alone: it tells the runner when this one has ended.

    Processes that a policy starts find nothing there.
    """
    nothing = os.open(os.devnull, os.O_RDWR)
    os.set_inheritable(runner, False)
    os.register_at_fork(after_in_child=lambda: os.dup2(nothing, runner, inheritable=False))
    return runner


def _end_with(parent: int) -> None:
    """A policy that hangs must not outlive a runner that was killed."""
    waiting = threading.Event()
    while not waiting.wait(_PARENT_CHECK_S):
        if os.getppid() != parent:
            os._exit(1)


class _Loaded(NamedTuple):
    policy: Policy
    skill: SkillManifest


def _load(request: Load) -> _Loaded:
    skill = SkillManifest.model_validate_json(request.skill)
    options = json.loads(request.options)
    try:
        policy = make_policy(
            request.policy, skill, options, lambda: load_robot(request.robot), request.profile
        )
    except MisfitError as error:
        if options != skill.policy.options:  # the deployment's
            raise
        raise error.located(of_options(locate_in_skill(skill.id))) from None
    return _Loaded(policy, skill)


def _answer(loaded: _Loaded | None, request: Request) -> Reply:
    if loaded is None:
        raise PolicyError("policy worker: asked before a policy was loaded")
    policy, skill = loaded
    if isinstance(request, Infer):
        said = policy.infer(request.observation())
        if isinstance(said, Done | Failed):
            return Ended.of(said)
        return pack_actions(said, skill.action_contract.dim, skill.horizon)
    assert isinstance(request, Reset)
    policy.reset()
    return Answer()


if __name__ == "__main__":
    raise SystemExit(main())
