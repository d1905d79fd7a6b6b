"""The supervisor with real processes: small scripts stand in for the services."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
import yaml

from fairlead.deploy.process_table import process_id
from fairlead.deploy.sockets import socket_path
from fairlead.errors import ServiceError
from fairlead_tools.supervisor.this_host import free_ports
from tests.supervisor.bench import STUBBORN, WAIT_S, WITH_A_CHILD, Bench, wait_until

pytestmark = [pytest.mark.asyncio, pytest.mark.processes]


async def test_started_services_become_ready_and_are_listed(bench: Bench) -> None:
    await bench.start()
    (entry,) = bench.registry.entries()
    assert entry.supervisor is not None and entry.supervisor.pid == os.getpid()
    assert [service.ready for service in entry.services.values()] == [True, True]
    await wait_until(lambda: ("hal", "hal: ready") in bench.lines, "it is printed")
    log = bench.state_dir / "logs" / "hal.log"
    await wait_until(log.exists, "it is logged")
    text = log.read_text(encoding="utf-8")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z PRINT hal: hal: ready\n", text)


async def test_services_have_groups_of_their_own_in_the_supervisors_session(bench: Bench) -> None:
    """Ctrl-C reaches the supervisor alone; the kernel gives processor time to them as to one."""
    await bench.start()
    pids = [bench.supervisor.pid("hal"), bench.supervisor.pid("runner")]
    assert [os.getpgid(pid) for pid in pids] == pids
    assert {os.getsid(pid) for pid in pids} == {os.getsid(0)}


@pytest.mark.parametrize("order", [["hal", "runner"], ["runner", "hal"]])
async def test_services_start_in_the_order_asked_for(bench: Bench, order: list[str]) -> None:
    await bench.supervisor.start(order)
    await bench.supervisor.wait_ready(WAIT_S)
    (entry,) = bench.registry.entries()
    assert list(entry.services) == order


async def test_stopping_leaves_no_process_and_no_entry(bench: Bench) -> None:
    await bench.start()
    pids = [bench.supervisor.pid("hal"), bench.supervisor.pid("runner")]
    assert await bench.supervisor.stop() == []
    assert [process_id(pid) for pid in pids] == [None, None]
    assert bench.registry.entries() == []


async def test_a_service_that_ignores_sigterm_is_killed_after_the_grace_and_named(
    bench: Bench,
) -> None:
    bench.scripts["runner"] = STUBBORN
    await bench.start()
    pid = bench.supervisor.pid("runner")
    assert await bench.supervisor.stop(grace_s=0.3) == ["runner"]
    assert process_id(pid) is None


async def test_a_stopped_process_is_ended_too(bench: Bench) -> None:
    await bench.start()
    pid = bench.supervisor.pid("hal")
    os.kill(pid, signal.SIGSTOP)
    assert await bench.supervisor.stop() == []
    assert process_id(pid) is None


async def test_what_a_dead_service_had_started_ends_before_it_is_started_again(
    bench: Bench,
) -> None:
    bench.scripts["hal"] = WITH_A_CHILD
    await bench.start()
    await wait_until(lambda: any(line.startswith("child ") for _, line in bench.lines), "a child")
    child = next(int(line.split()[1]) for _, line in bench.lines if line.startswith("child "))
    bench.keep()
    os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
    died = await bench.event("died")
    assert died == "hal was killed by signal 9; starting it again in 0.5 s"
    assert process_id(child) is None
    restarted = await bench.event("restarted")
    assert restarted == f"hal started again (pid {bench.supervisor.pid('hal')}, #1)"
    assert await bench.event("ready") == "hal is ready again"


async def test_a_service_that_dies_before_it_is_ready_fails_the_start_with_its_last_lines(
    bench: Bench,
) -> None:
    bench.scripts["runner"] = "echo 'ERROR runner: no such policy'; exit 3"
    await bench.supervisor.start()
    with pytest.raises(ServiceError) as caught:
        await bench.supervisor.wait_ready(WAIT_S)
    log = bench.state_dir / "logs" / "runner.log"
    assert str(caught.value) == (
        f"runner: ended with status 3; its last lines ({log}):\n"
        "  [runner] ERROR runner: no such policy"
    )


async def test_a_program_that_is_not_there_fails_the_start(bench: Bench) -> None:
    bench.program = "./no-such-hal"
    with pytest.raises(ServiceError) as caught:
        await bench.supervisor.start()
    assert str(caught.value) == "hal: cannot start ./no-such-hal: no such program"


async def test_a_service_that_never_gets_ready_fails_the_start_after_the_timeout(
    bench: Bench,
) -> None:
    bench.scripts["runner"] = "echo loading; exec sleep 1000"
    await bench.supervisor.start()
    with pytest.raises(ServiceError, match=r"runner: not ready after 0\.3 s; its last lines"):
        await bench.supervisor.wait_ready(0.3)


async def test_a_second_start_of_a_running_deployment_is_refused_naming_pid_and_fix(
    bench: Bench,
) -> None:
    await bench.supervisor.start()
    name = bench.supervisor.name
    with pytest.raises(ServiceError) as caught:
        await bench.another().start()
    assert str(caught.value) == (
        f"deployment {name} is already running (pid {os.getpid()}); "
        f"stop it first: fairlead down {name}"
    )
    assert len(bench.registry.entries()) == 1  # the refusal did not forget the running one


def open_to_all(file: Path, port: int) -> None:
    content = yaml.safe_load(file.read_text(encoding="utf-8")) | {"access": "open"}
    content["services"]["runner"]["listen"] = f"tcp/127.0.0.1:{port}"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")


@pytest.mark.parametrize("access", ["closed", "open"])
async def test_a_busy_place_is_refused_naming_service_place_pid_and_fix(
    access: str, bench: Bench, deployment_file: Path
) -> None:
    port = free_ports(1)[0]
    if access == "open":
        open_to_all(deployment_file, port)
        bench.supervisor = bench.another()
    path = socket_path(bench.supervisor.deployment.listen("runner"))
    family, place = ("UNIX", repr(path)) if path else ("INET", f"('127.0.0.1', {port})")
    program = f"""
        import socket
        s = socket.socket(socket.AF_{family}); s.bind({place}); s.listen(); print("on", flush=True)
        input()
    """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as squatter:  # noqa: ASYNC220 - at once
        assert squatter.stdout is not None
        squatter.stdout.readline()
        with pytest.raises(ServiceError) as caught:
            await bench.supervisor.start()
        squatter.kill()
    what = f"socket {path}" if path else f"port {port}"
    assert f"runner: its {what} is taken by pid {squatter.pid} (" in str(caught.value)
    assert f"stop that first (kill {squatter.pid})" in str(caught.value)


async def test_leftover_processes_of_a_killed_run_are_refused_until_they_are_gone(
    bench: Bench,
) -> None:
    await bench.supervisor.start()
    (entry,) = bench.registry.entries()
    await bench.supervisor.stop()
    with subprocess.Popen(["sleep", "1000"]) as leftover:  # noqa: ASYNC220 - likewise
        process = process_id(leftover.pid)
        assert process is not None
        services = {"hal": type(entry.services["hal"])(process, True, 0)}
        dead = type(process)(2**22 + 1, 1)
        bench.registry.write(type(entry)(entry.name, "", "", dead, services))
        with pytest.raises(ServiceError) as caught:
            await bench.supervisor.start()
        leftover.kill()
    assert str(caught.value) == (
        f"deployment {entry.name}: processes that were started before still run: "
        f"hal (pid {process.pid}); end them first: fairlead down {entry.name}"
    )
    await bench.supervisor.start()


async def test_children_die_with_a_supervisor_that_is_killed(
    deployment_file: Path, tmp_path: Path
) -> None:
    program = f"""
        import asyncio
        from pathlib import Path
        from fairlead.deploy.deployment import load_deployment
        from fairlead.deploy.registry import Registry
        from fairlead_tools.supervisor import Supervisor
        file, folder = Path({str(deployment_file)!r}), Path({str(tmp_path)!r})
        supervisor = Supervisor(
            file, load_deployment(file), folder / "state", registry=Registry(folder / "registry"),
            command=lambda *_: ["sh", "-c", "trap '' TERM; echo x: ready; exec sleep 1000"],
        )
        async def run():
            await supervisor.start()
            await supervisor.wait_ready({WAIT_S})
            print(supervisor.pid("hal"), supervisor.pid("runner"), flush=True)
            await asyncio.Event().wait()
        asyncio.run(run())
    """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:  # noqa: ASYNC220 - likewise
        assert parent.stdout is not None
        pids = [int(word) for word in parent.stdout.readline().split()]
        assert all(process_id(pid) for pid in pids) and len(pids) == 2
        parent.kill()
    await wait_until(lambda: not any(process_id(pid) for pid in pids), "the children are gone")
