"""A service that writes down on which thread its entry points are called, and what it starts.

``python recorded_threads.py FILE MODULE ...`` is ``python -m MODULE ...``.
"""

from __future__ import annotations

import functools
import runpy
import sys
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

CLASSES = {
    "fairlead.hal.serve": {
        "HalCore": "fairlead.hal.core",
        "EpisodeResetHandler": "fairlead.hal.episode_reset",
        "TickPublisher": "fairlead.hal.tick_publisher",
    },
    "fairlead_state_assembler": {
        "AssemblerCore": "fairlead_state_assembler.core",
        "AssemblerTransport": "fairlead_state_assembler.transport",
    },
    "fairlead_skill_runner": {
        "GoalRun": "fairlead_skill_runner.goal_run",
        "PolicyWorker": "fairlead_skill_runner.policy_worker",
        "RunCore": "fairlead_skill_runner.run_core",
    },
}
"""Where each class is, by the module of the service it belongs to."""


def main() -> None:
    """Wrap the entry points of one service, then be that service."""
    file, module = Path(sys.argv[1]), sys.argv[2]
    del sys.argv[1:3]
    lines = file.open("a", buffering=1, encoding="utf-8")
    for name, where in CLASSES[module].items():
        owner = getattr(import_module(where), name)
        for method in [one for one in vars(owner) if callable(getattr(owner, one))]:
            if not method.startswith("_"):
                setattr(owner, method, recorded(getattr(owner, method), lines))
    start = threading.Thread.start

    def recorded_start(thread: threading.Thread) -> None:
        if not thread.name.startswith(("Thread-", "asyncio")):  # a library's
            lines.write(f"started {name_of(thread)}\n")
        start(thread)

    threading.Thread.start = recorded_start  # type: ignore[assignment, method-assign]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


def recorded(method: Any, lines: Any) -> Any:
    """The method, which writes its name and each thread that calls it."""
    seen: set[str] = set()

    @functools.wraps(method)
    def call(*arguments: Any, **named: Any) -> Any:
        thread = thread_name()
        if thread not in seen:
            seen.add(thread)
            lines.write(f"{method.__qualname__} {thread}\n")
        return method(*arguments, **named)

    return call


def thread_name() -> str:
    """``main``, ``tick``, or ``receive`` for a thread that Python did not start."""
    thread = threading.current_thread()
    if thread is threading.main_thread():
        return "main"
    is_foreign = isinstance(thread, threading._DummyThread)
    return "receive" if is_foreign else name_of(thread)


def name_of(thread: threading.Thread) -> str:
    """Its name, or its pool's."""
    return thread.name.partition("_")[0]


if __name__ == "__main__":
    main()
