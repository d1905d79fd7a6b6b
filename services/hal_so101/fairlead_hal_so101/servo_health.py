"""Whether servos measure what they may."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fairlead_hal_so101.options import ServoLimits
from fairlead_hal_so101.servo_reading import ServoReading


class ServoHealth:
    """Counts for how many ticks in a row each servo was beyond a limit.

    Args:
        names: of the servos, for what is said.

    Attributes:
        complaint: what is wrong now, "" if nothing is.
    """

    def __init__(self, names: Sequence[str], limits: ServoLimits) -> None:
        self._names, self._limits = names, limits
        self._beyond: dict[tuple[int, str], int] = {}
        self.complaint = ""

    def look(self, readings: Sequence[ServoReading]) -> None:
        """Take one tick's measurements."""
        found = {
            (index, kind): text
            for index, reading in enumerate(readings)
            for kind, text in self._findings(reading)
        }
        self._beyond = {key: self._beyond.get(key, 0) + 1 for key in found}
        lasting = [key for key, ticks in self._beyond.items() if ticks >= self._limits.ticks]
        self.complaint = "; ".join(f"servo {self._names[key[0]]}: {found[key]}" for key in lasting)

    def _findings(self, reading: ServoReading) -> Iterator[tuple[str, str]]:
        limits = self._limits
        low, high = limits.voltage_v
        if reading.faults:
            yield "faults", f"says {' and '.join(one.name or '' for one in reading.faults).lower()}"
        if reading.temperature_c > limits.temperature_c:
            yield "heat", f"{reading.temperature_c} C, limit {limits.temperature_c:g} C"
        if not low <= reading.voltage_v <= high:
            yield "voltage", f"{reading.voltage_v:g} V, limits {low:g} and {high:g} V"
        if reading.current_a > limits.current_a:
            yield "current", f"{reading.current_a:.2f} A, limit {limits.current_a:g} A"
        if abs(reading.load) > limits.load:
            yield "load", f"load {abs(reading.load):.2f}, limit {limits.load:g}"
