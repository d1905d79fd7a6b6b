"""A service as a process, for tests: ``python stubborn_service.py MODE`` + usual arguments."""

from __future__ import annotations

import asyncio
import logging
import sys
import threading

from fairlead.deploy import stop_signals
from fairlead.service import ServiceContext, announce_ready, run_service

MODE = sys.argv.pop(1)
LINES = 3000


async def fail() -> None:
    """A bug in a task."""
    raise KeyError("no such part")


async def body(context: ServiceContext) -> None:
    """Wait to be stopped; ``deaf`` then hangs, ``thread`` hangs in a thread at the end.

    ``starting`` never becomes ready; in ``task`` a task of the service fails. ``talks`` logs more
    than a pipe holds, then makes the file ``talked``.
    """
    if MODE == "starting":
        print("not ready for a long time", flush=True)
        await asyncio.to_thread(threading.Event().wait)
    announce_ready(context)
    if MODE == "task":
        context.tasks.create_task(fail())
    if MODE == "talks":
        for number in range(LINES):
            logging.getLogger("talks").info("line %d %s", number, "of many " * 20)
        (context.state_dir / "talked").touch()
    await context.stopping.wait()
    if MODE == "deaf":
        threading.Event().wait()
    if MODE == "thread":
        threading.Thread(target=threading.Event().wait).start()


if __name__ == "__main__":
    stop_signals.END_S = 0.5
    sys.exit(run_service("stubborn", body))
