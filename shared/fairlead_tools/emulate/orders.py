"""What a person types while servos are emulated: faults, and a hand on the arm."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from fairlead.errors import ConfigError, expected
from fairlead_tools.emulate.servo_arm import ServoArm
from fairlead_tools.emulate.servo_bus import ServoBus
from fairlead_tools.emulate.sts3215 import Sts3215


class Emulated(NamedTuple):
    """An arm and its bus."""

    arm: ServoArm
    bus: ServoBus


class Order(NamedTuple):
    """arguments: how many numbers, at least and at most. carry_out: takes them; may answer."""

    usage: str
    text: str
    arguments: tuple[int, int]
    carry_out: Callable[[Emulated, list[float]], str | None]


def _noise(emulated: Emulated, numbers: list[float]) -> None:
    emulated.bus.faults.noise = _chance(numbers[0])


def _wrong(emulated: Emulated, numbers: list[float]) -> str:
    return f"{emulated.bus.faults.wrong}"


def _lose(emulated: Emulated, numbers: list[float]) -> None:
    emulated.bus.faults.lost = _chance(numbers[0])


def _deaf(emulated: Emulated, numbers: list[float]) -> None:
    emulated.bus.faults.deaf = _chance(numbers[0])


def _late(emulated: Emulated, numbers: list[float]) -> None:
    emulated.bus.faults.late, emulated.bus.faults.late_s = _chance(numbers[0]), numbers[1] / 1e3


def _unplug(emulated: Emulated, numbers: list[float]) -> None:
    emulated.bus.reached = _servo(emulated, numbers[0])[0] - 1


def _plug(emulated: Emulated, numbers: list[float]) -> None:
    for servo in emulated.arm.servos[emulated.bus.reached :]:
        servo.power_up()
    emulated.bus.reached = len(emulated.arm.servos)


def _dip(emulated: Emulated, numbers: list[float]) -> None:
    for servo in emulated.arm.servos:
        servo.power_up()


def _voltage(emulated: Emulated, numbers: list[float]) -> None:
    for servo in emulated.arm.servos:
        servo.voltage = _within("VOLTS", numbers[0], 0.0, 25.0)


def _temperature(emulated: Emulated, numbers: list[float]) -> None:
    servo = _servo(emulated, numbers[0])[1]
    servo.temperature_c = _within("DEGREES", numbers[1], 0.0, 200.0)


def _overload(emulated: Emulated, numbers: list[float]) -> None:
    _servo(emulated, numbers[0])[1].overload()


def _sensor(emulated: Emulated, numbers: list[float]) -> None:
    _servo(emulated, numbers[0])[1].sensor_fails = True


def _pull(emulated: Emulated, numbers: list[float]) -> None:
    target = _within("RAD", numbers[1], -10.0, 10.0) if len(numbers) > 1 else None
    emulated.arm.pull(_servo(emulated, numbers[0])[0], target)


def _where(emulated: Emulated, numbers: list[float]) -> str:
    return f"{emulated.arm.position(_servo(emulated, numbers[0])[0]):.4f}"


ORDERS = {
    "noise": Order("noise SHARE", "so many answers have a wrong byte", (1, 1), _noise),
    "wrong": Order("wrong", "so many answers have had a wrong byte", (0, 0), _wrong),
    "lose": Order("lose SHARE", "so many answers never come", (1, 1), _lose),
    "deaf": Order("deaf SHARE", "so many packets pass a servo by unheard", (1, 1), _deaf),
    "late": Order("late SHARE MS", "so many answers come late", (2, 2), _late),
    "unplug": Order("unplug ID", "this servo and those behind it are off", (1, 1), _unplug),
    "plug": Order("plug", "all servos have power and signal again", (0, 0), _plug),
    "dip": Order("dip", "brown-out: all servos start anew, limp", (0, 0), _dip),
    "voltage": Order("voltage VOLTS", "of the supply; 12 at first", (1, 1), _voltage),
    "temperature": Order("temperature ID DEGREES", "in a servo; 30 at first", (2, 2), _temperature),
    "overload": Order("overload ID", "as if it had been blocked too long", (1, 1), _overload),
    "sensor": Order("sensor ID", "its encoder breaks", (1, 1), _sensor),
    "pull": Order("pull ID [RAD]", "a hand takes the joint there; or lets go", (1, 2), _pull),
    "where": Order("where ID", "the joint is [rad]", (1, 1), _where),
}


def carry_out(emulated: Emulated, line: str) -> str:
    """Do what one line says; what there is to say about it.

    Raises:
        ConfigError: for an unknown word, or numbers that do not fit.
    """
    word, *given = line.split()
    order = ORDERS.get(word)
    if order is None:
        raise ConfigError(expected("emulate", "an order", repr(word), [*ORDERS, "help", "quit"]))
    try:
        numbers = [float(one) for one in given]
    except ValueError:
        numbers = []
    least, most = order.arguments
    if not least <= len(given) == len(numbers) <= most:
        raise ConfigError(expected(f"emulate: {word}", order.usage, repr(line.strip())))
    return order.carry_out(emulated, numbers) or f"done: {line}"


def _chance(share: float) -> float:
    return _within("SHARE", share, 0.0, 1.0)


def _within(what: str, number: float, lowest: float, highest: float) -> float:
    if not lowest <= number <= highest:
        raise ConfigError(expected("emulate", f"{what} from {lowest:g} to {highest:g}", number))
    return number


def _servo(emulated: Emulated, number: float) -> tuple[int, Sts3215]:
    for servo_id, servo in enumerate(emulated.arm.servos, start=1):
        if servo_id == number:
            return servo_id, servo
    raise ConfigError(expected("emulate", f"an ID from 1 to {len(emulated.arm.servos)}", number))
