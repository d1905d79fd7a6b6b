"""A start that fails half-way, while the network already calls the gate."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from bench.equipment.running_gate import RunningGate
from bench.equipment.scripted_hal import ScriptedHal
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

pytestmark = pytest.mark.processes

FAULT = r"""
#include <atomic>
#include <chrono>
#include <dlfcn.h>
#include <thread>
static std::atomic<int> samples{0};
template <class Call> Call real(const char* name) {
  return reinterpret_cast<Call>(dlsym(RTLD_NEXT, name));
}
extern "C" signed char z_liveliness_declare_token(const void*, void*, const void*, void*) {
  return -128;
}
extern "C" const void* z_sample_payload(const void* sample) {
  ++samples;
  return real<const void* (*)(const void*)>("z_sample_payload")(sample);
}
extern "C" void z_subscriber_drop(void* moved) {
  const int before = samples;
  for (int i = 0; i < 2000 && samples < before + 20; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  real<void (*)(void*)>("z_subscriber_drop")(moved);
}
"""
"""In front of the Zenoh library: the last thing that a start declares fails, and no subscriber is
let go before it was called 20 times more."""


def test_what_the_network_calls_outlives_the_calls_also_where_starting_fails(
    config: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, library = tmp_path / "fault.cpp", tmp_path / "libfault.so"
    source.write_text(FAULT)
    subprocess.run(["g++", "-shared", "-fPIC", "-O1", source, "-o", library], check=True)
    port = free_ports(1)[0]
    bus = ZenohBus(Endpoints(listen=[f"tcp/127.0.0.1:{port}"]))
    monkeypatch.setenv("LD_PRELOAD", str(library))
    gate = RunningGate(config, tmp_path / "state", connect=[port])
    try:
        hal = ScriptedHal(bus, config)
        while gate.process.poll() is None:
            hal.publish_state()
        assert gate.wait_exit() == 1, gate.lines[-3:]
        assert gate.lines[-1].startswith("ERROR fairlead-safety: zenoh: cannot declare ")
    finally:
        gate.close()
        bus.close()
