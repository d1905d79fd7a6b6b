"""Processes that SIGKILL does not end at once: they are named, and nobody forgets them."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from fairlead.deploy.process_table import group_members
from fairlead.errors import ServiceError
from tests.supervisor.bench import Bench, wait_until

pytestmark = [pytest.mark.asyncio, pytest.mark.processes]

LETS_TRACE = (
    f"exec {sys.executable} -c 'import ctypes, signal; "
    "ctypes.CDLL(None).prctl(0x59616D61, ctypes.c_ulong(-1)); "  # PR_SET_PTRACER, anybody
    'print("{name}: ready", flush=True); signal.pause()\''
)
HOLDS_AT_EXIT = """
    import ctypes, sys
    libc = ctypes.CDLL(None, use_errno=True)
    seize, trace_exit = 0x4206, 0x40  # PTRACE_SEIZE, PTRACE_O_TRACEEXIT
    libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    print(libc.ptrace(seize, int(sys.argv[1]), None, trace_exit), flush=True)
    input()
"""


@contextmanager
def held_at_exit(pid: int) -> Iterator[None]:
    """The process ends no further than to its exit, as one stuck in the kernel."""
    command = [sys.executable, "-c", textwrap.dedent(HOLDS_AT_EXIT), str(pid)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as tracer:
        assert tracer.stdout is not None
        assert tracer.stdout.readline() == b"0\n", "this machine lets nobody trace"
        yield
        tracer.kill()


@contextmanager
def no_more_open_files() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


async def test_what_lives_on_after_sigkill_is_named_and_stays_listed(bench: Bench) -> None:
    bench.scripts["runner"] = LETS_TRACE
    await bench.start()
    pid, name = bench.supervisor.pid("runner"), bench.supervisor.name
    with held_at_exit(pid):
        with pytest.raises(ServiceError) as caught:
            await bench.supervisor.stop(grace_s=0.0)
        assert str(caught.value) == (
            f"deployment {name}: processes live on after SIGKILL: runner (pid {pid}); look at "
            f"them: fairlead ps; when what holds them has let go: fairlead down {name}"
        )
        (entry,) = bench.registry.entries()
        assert [one.pid for one in entry.leftovers] == [pid]
        with pytest.raises(ServiceError, match=rf"still run: runner \(pid {pid}\)"):
            await bench.supervisor.start()
    await wait_until(lambda: not group_members(pid), "it has ended")


async def test_a_service_is_not_started_again_beside_what_it_left(bench: Bench) -> None:
    bench.scripts["hal"] = f"({LETS_TRACE}) & wait; exit"
    await bench.start()
    group = bench.supervisor.pid("hal")
    child = max(pid for pid in group_members(group) if pid != group)
    bench.keep()
    with held_at_exit(child):
        os.kill(group, signal.SIGKILL)
        assert (await bench.event("failed")).startswith(
            f"hal cannot be started again: pid {child} of it lives on after SIGKILL; next attempt"
        )
    assert await bench.event("ready") == "hal is ready again"


async def test_a_kernel_that_does_not_say_what_runs_ends_no_other_service(bench: Bench) -> None:
    await bench.start()
    bench.keep()
    runner = bench.supervisor.pid("runner")
    with no_more_open_files():
        os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
        while not (said := await bench.event("failed")).startswith("hal cannot be started again: "):
            continue  # nor can it be listed what runs
        assert "Too many open files" in said
    assert await bench.event("ready") == "hal is ready again"
    assert bench.supervisor.pid("runner") == runner


async def test_a_group_that_has_ended_is_not_killed_again_when_its_number_is_anothers(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    await bench.start()
    child = bench.supervisor._slots["runner"].child
    assert await child.kill_group() == []
    killed: list[int] = []
    monkeypatch.setattr("fairlead_tools.supervisor.child.group_members", lambda _: [4711])
    monkeypatch.setattr(os, "killpg", lambda group, _: killed.append(group))
    assert await child.kill_group() == []
    assert killed == []
