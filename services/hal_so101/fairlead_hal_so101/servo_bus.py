"""The bus of an arm's servos, by rustypot: one read and one write for all, if nothing is lost."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fairlead.errors import ConfigError, HardwareError, expected
from fairlead_hal_so101.calibration import Calibration
from fairlead_hal_so101.servo_reading import FIRST, LENGTH, ServoReading, servo_reading

if TYPE_CHECKING:
    from rustypot import Sts3215PyController


RATE = 1_000_000
MODEL = 777
_QUIET_S = 0.0005
"""For so long each servo that was asked may go on answering after a failed read."""
_AGAIN = 1.5
"""Servos are asked again for so many times of what one answer may take."""
_PATIENT_S = 0.05
"""For a servo to answer while nothing moves."""
GOAL_POSITION = 42


class LostAnswerError(Exception):
    """A read or write of all servos failed, for a reason that may pass."""


class ServoBus:
    """The servos of one arm on a serial port.

    Args:
        names: of the servos by id, for errors.
        who: complains in errors.

    Raises:
        ConfigError: rustypot is not installed, or the port cannot be opened.
    """

    def __init__(self, port: str, names: dict[int, str], answer_timeout_s: float, who: str) -> None:
        self._port, self._names, self._timeout_s = port, names, answer_timeout_s
        self._ids, self._who = list(names), who
        self._controller = _open(port, max(_PATIENT_S, answer_timeout_s), who)

    def check_servos(self) -> None:
        """Whether the servos of the arm are there, and no others.

        Raises:
            ConfigError: naming the ids that are missing, that nobody expects, or another model.
            HardwareError: the port is gone.
        """
        silent, scanned = self.silent(retries=2), self._scan()
        found = sorted({*scanned, *self._ids} - {*silent})
        models = {one: scanned.get(one) or self.get(one, "model_number") for one in found}
        if models != dict.fromkeys(sorted(self._ids), MODEL):
            seen = ", ".join(
                str(one) if model == MODEL else f"{one} of model {model}"
                for one, model in models.items()
            )
            wanted = f"STS3215 servos {', '.join(map(str, self._ids))} and no others"
            got = f"{seen or 'none'}; look at power, cables and ids"
            raise ConfigError(expected(f"{self._who}: {self._port}", wanted, got))
        self._controller.set_timeout(self._timeout_s)

    def read(self) -> list[ServoReading]:
        """Measure all servos by one read of the bus; where it fails, each by one of its own.

        A wrong byte spoils a read of all servos: another one would be lost more often.

        Raises:
            LostAnswerError: a servo did not answer in time.
            HardwareError: the port is gone.
        """
        try:
            return self._read(self._ids)
        except LostAnswerError:
            give_up_s = time.monotonic() + _AGAIN * self._timeout_s
        return [self._read_one(one, give_up_s) for one in self._ids]

    def _read_one(self, servo_id: int, give_up_s: float) -> ServoReading:
        """One servo, asked until it answers, but not after ``give_up_s`` (monotonic)."""
        reason = f"servo {self.named([servo_id])}: no time was left to ask it again"
        while time.monotonic() <= give_up_s:
            try:
                return self._read([servo_id])[0]
            except LostAnswerError as error:
                reason = str(error)
        raise LostAnswerError(reason)

    def _read(self, ids: Sequence[int]) -> list[ServoReading]:
        try:
            answers = self._controller.sync_read_raw_data_with_error(list(ids), FIRST, LENGTH)
        except (RuntimeError, OSError) as error:
            reason = self._reason(error)
            time.sleep(len(ids) * _QUIET_S)
            raise LostAnswerError(reason) from None
        return [servo_reading(bytes(data), error) for data, error in answers]

    def write_all(self, address: int, size: int, values: Sequence[int]) -> None:
        """Write one number of ``size`` bytes into every servo, by one packet without an answer.

        Raises:
            LostAnswerError: it could not be sent.
            HardwareError: the port is gone.
        """
        data = [list(value.to_bytes(size, "little")) for value in values]
        try:
            self._controller.sync_write_raw_data(self._ids, address, data)
        except (RuntimeError, OSError) as error:
            raise LostAnswerError(self._reason(error)) from None

    def get(self, servo_id: int, name: str) -> int:
        """A register by rustypot's name, patiently.

        Raises:
            HardwareError: the servo does not answer.
        """
        try:
            return self._controller.read_register(servo_id, name, retries=3)
        except (RuntimeError, OSError) as error:
            raise HardwareError(f"{self._who}: {self._reason(error)}") from None

    def put(self, servo_id: int, name: str, value: int) -> None:
        """Write a register by rustypot's name, patiently.

        Raises:
            HardwareError: the servo does not answer.
        """
        try:
            self._controller.write_register(servo_id, name, value, retries=3)
        except (RuntimeError, OSError) as error:
            raise HardwareError(f"{self._who}: {self._reason(error)}") from None

    def why_lost(self, reason: str) -> str:
        """Which servos are silent, after answers were lost; ``reason``, if all answer now."""
        silent = self.silent()
        if len(silent) == len(self._ids):
            return "no servo answers: bus cable out, or power off"
        if silent:
            return f"servo {self.named(silent)} does not answer: its cable, power or id"
        return reason

    def silent(self, retries: int = 1) -> list[int]:
        """The servos that do not answer now, asked one by one."""
        return [one for one in self._ids if not self._answers(one, retries)]

    def named(self, ids: Sequence[int]) -> str:
        """Servos as errors call them."""
        return ", ".join(f"{one} ({self._names[one]})" for one in ids)

    def close(self) -> None:
        """Let go of the port."""
        self._controller.close()

    def _answers(self, servo_id: int, retries: int) -> bool:
        try:
            return self._controller.read_register(servo_id, "id", retries) == servo_id
        except (RuntimeError, OSError) as error:
            self._reason(error)
            return False

    def _scan(self) -> dict[int, int]:
        try:
            found: dict[int, int] = self._controller.broadcast_scan()
        except (RuntimeError, OSError) as error:
            raise HardwareError(f"{self._who}: {self._reason(error)}") from None
        return found

    def _reason(self, error: Exception) -> str:
        """What the library says, with the servo's name.

        Raises:
            HardwareError: the port is gone.
        """
        text = str(error)
        if "I/O error" in text or isinstance(error, OSError):
            gone = "is gone: adapter unplugged?"
            raise HardwareError(f"{self._who}: port {self._port} {gone} ({text})") from None
        motor = re.match(r"motor (\d+): (.*)", text)
        if motor is None:
            return text.lower()
        return f"servo {self.named([int(motor.group(1))])}: {motor.group(2).lower()}"


def _open(port: str, timeout_s: float, who: str) -> Sts3215PyController:
    try:
        from rustypot import Sts3215PyController
    except ImportError:
        raise ConfigError(
            f"{who}: expected the package rustypot, got none; pip install 'fairlead[so101]'"
        ) from None
    try:
        return Sts3215PyController(port, RATE, timeout_s)
    except (OSError, RuntimeError) as error:
        raise ConfigError(
            expected(f"{who}: port", "a serial port that nobody else uses", f"{port}: {error}")
        ) from None


_POSITION_MODE = 0


def calibrated_bus(
    port: str, calibration: Calibration, file: Path, answer_timeout_s: float, who: str
) -> ServoBus:
    """Open a port, and compare its servos with the calibration.

    Args:
        file: that the calibration is from, for errors.
        who: complains in errors.

    Raises:
        ConfigError: what is on the port is not the arm that was calibrated.
        HardwareError: it does not answer.
    """
    names = {servo.id: servo.joint for servo in calibration.servos}
    bus = ServoBus(port, names, answer_timeout_s, who)
    try:
        bus.check_servos()
        for one in calibration.servos:
            wanted = {
                "operating_mode": _POSITION_MODE,
                "homing_offset": one.homing_offset_steps,
                "min_position_limit": one.lower_steps,
                "max_position_limit": one.upper_steps,
            }
            for name, value in wanted.items():
                if (got := bus.get(one.id, name)) != value:
                    raise ConfigError(
                        f"{who}: servo {bus.named([one.id])}: expected {name} {value} ({file}), "
                        f"got {got}: another arm, or calibrated elsewhere; fairlead calibrate so101"
                    )
    except BaseException:
        bus.close()
        raise
    return bus
