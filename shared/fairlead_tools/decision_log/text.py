"""Decisions of the gate in words: what was asked, why it did not pass, what would have."""

from __future__ import annotations

import math
from pathlib import Path

from fairlead.paths import repo_root
from fairlead.wire.gate_checks import CHECKS
from fairlead.wire.verdict_text import (
    check_title,
    example_text,
    is_rule,
    numbers_of,
    place_of,
    told_apart,
    value_and_limit,
    with_unit,
)
from fairlead_tools.decision_log.declared_limit import DeclaredLimit, declared_limit
from fairlead_tools.decision_log.explanation import (
    Answer,
    Chunk,
    Explanation,
    Judged,
    Latch,
    Nearest,
    Passes,
    Stop,
)


def decision_lines(asked: Explanation, decision: Answer | Stop | Latch) -> list[str]:
    """One decision as lines of text, the first without indentation."""
    if isinstance(decision, Answer):
        return _answer_lines(asked, decision)
    return _ended_lines(asked, decision)


def _ended_lines(asked: Explanation, ended: Stop | Latch) -> list[str]:
    what = "stopped" if isinstance(ended, Stop) else "latched"
    cause = " ".join(ended.cause.removeprefix(f"{what}: ").split())
    now = asked.status
    held = now is not None and (
        ended.latch_id == now.latch_id
        if isinstance(ended, Latch)
        else bool(set(ended.stop_ids) & set(now.stop_ids))
    )
    lines = [f"tick {ended.tick}: the gate {what}", _line("why", cause)]
    if hint := _hint_of(cause):
        lines.append(
            _line("limit", f"fairlead robot show {asked.robot} --profile {asked.profile} --sources")
        )
        lines.append(_line("first", hint))
    if held and now is not None and now.fix:
        return [*lines, _line("do", f"when the cause has gone: {now.fix}")]
    return [*lines, _line("since", f"reset; the log's newest state is {now.state if now else '?'}")]


def _hint_of(cause: str) -> str:
    """What to look at after a stop that a measured state raised; its cause begins with G0nn."""
    code = cause[1:4]
    return CHECKS[int(code)].hint if code in ("040", "041", "042", "043") else ""


def _answer_lines(asked: Explanation, answer: Answer) -> list[str]:
    lines = [_headline(answer)]
    if answer.chunk is not None:
        lines.append(_line("asked", _asked(answer.chunk)))
    if answer.judged_again:
        lines.append(
            _line("when", "rows released before, judged again: the robot was found elsewhere")
        )
    if answer.outcome == "released":
        return lines + [_line("margin", _nearest(one)) for one in answer.nearest or ()]
    lines.append(_line("why", _why(answer)))
    lines += _limit_lines(asked, answer)
    if answer.would_pass is not None:
        lines.append(_line("passes", _passes(answer, answer.would_pass)))
    if answer.code in CHECKS:
        lines.append(_line("do", CHECKS[answer.code].hint))
    return lines


def _headline(answer: Answer) -> str:
    skill = f" (skill {answer.chunk.skill})" if answer.chunk and answer.chunk.skill else ""
    whose = f"chunk {answer.seq} of {answer.source}{skill}"
    ticks = f"ticks {answer.released_first} to {answer.released_last}"
    rows = answer.released_last - answer.released_first + 1
    if answer.outcome == "released":
        return f"tick {answer.tick}: {whose} released, {_rows(rows)} for {ticks}"
    if answer.outcome == "truncated":
        return f"tick {answer.tick}: {whose} truncated, {_rows(rows)} released for {ticks}"
    return f"tick {answer.tick}: {whose} refused, nothing of it moves"


def _asked(chunk: Chunk) -> str:
    parts = ", ".join(
        f"{one.part} {one.mode}" + (f" in {one.frame}" if one.frame else "") for one in chunk.parts
    )
    last = chunk.start_tick + max(chunk.rows, 1) - 1
    return (
        f"{_rows(chunk.rows)} of {parts} for ticks {chunk.start_tick} to {last}, "
        f"from the state of tick {chunk.obs_tick}"
    )


def _why(answer: Answer) -> str:
    what = f"G{answer.code:03d} {check_title(answer.code)}"
    row = f"row {answer.row}" if answer.row >= 0 else ""
    where = ", ".join(text for text in (row, place_of(answer)) if text)
    if is_rule(answer) or not where:
        said = ", ".join(text for text in (where, numbers_of(answer)) if text)
        return f"{what}: {said}" if said else what
    value, limit = value_and_limit(answer)
    text = f"{what}: {where} is {value}, limit {limit}"
    over = answer.margin
    if isinstance(over, float) and math.isfinite(over):
        text += f", {with_unit(abs(over), answer.unit)} beyond it"
    return text


def _limit_lines(asked: Explanation, answer: Answer) -> list[str]:
    if is_rule(answer):
        return []
    lines = []
    mode = answer.chunk.mode if answer.chunk is not None else ""
    found = declared_limit(Path(asked.config_file), asked.profile, answer, mode)
    if found is not None:
        lines.append(
            _line("limit", f"{_from_root(found.file)}: {found.key}{_tightened(found, answer)}")
        )
    if answer.limit_source:
        lines.append(_line("" if found else "limit", answer.limit_source))
    return lines


def _from_root(file: Path) -> Path:
    root = repo_root()
    return file.relative_to(root) if file.is_relative_to(root) else file


def _tightened(found: DeclaredLimit, verdict: Judged) -> str:
    if found.number is None or not isinstance(verdict.limit, float):
        return ""
    if abs(verdict.limit) < abs(found.number) * (1 - 1e-9):
        return f" is {found.number:g}, made tighter by the claim, or changed since"
    return ""


def _passes(answer: Answer, passes: Passes) -> str:
    if passes.change == "none":
        return f"nothing nearer to rest: {_at_rest(answer, passes)}"
    if passes.change == "rounded":
        return (
            f"the whole chunk, asked of this gate with every number of {answer.part} "
            "0 or 1, whichever is nearer"
        )
    assert passes.scale is not None
    scale, _ = told_apart(passes.scale, 1.0, digits=4)
    if passes.change == "rows":
        return (
            f"the whole chunk, asked of this gate with every number of {answer.part} times {scale}"
            f"{_about(answer)}"
        )
    where = f"{answer.part} {answer.axis} in row {answer.row}"
    if passes.number is not None and passes.asked is not None:
        number, asked = told_apart(_trimmed(passes.number, passes.asked), passes.asked)
        return (
            f"the whole chunk, asked of this gate with {where} at "
            f"{with_unit(number, answer.unit)} instead of {with_unit(asked, answer.unit)}"
        )
    before = "the row before" if passes.about_row else "what is measured"
    return (
        f"the whole chunk, asked of this gate with the change of {where} from {before} "
        f"times {scale}"
    )


def _at_rest(answer: Answer, passes: Passes) -> str:
    if passes.still is None:
        return f"with {answer.part} at rest the gate gives no verdict"
    still = passes.still
    return f"with {answer.part} at rest it is G{still.code:03d} {still.axis} in row {still.row}"


def _about(answer: Answer) -> str:
    mode = answer.chunk.mode if answer.chunk is not None else ""
    if mode == "cartesian_pose":
        return " about the measured pose"
    positions = ("joint_position", "dex_hand_joint", "gripper_position")
    return " about the measured position" if mode in positions else ""


def _nearest(nearest: Nearest) -> str:
    if nearest.scale is None or nearest.beyond is None:
        return f"{nearest.part}: even 100 times its numbers would have passed"
    beyond = nearest.beyond
    return (
        f"{nearest.part}: up to {nearest.scale:.4g} times its numbers, asked of this gate; then "
        f"G{beyond.code:03d} {beyond.axis} in row {beyond.row}, "
        f"limit {with_unit(beyond.limit, beyond.unit)}"
    )


def _rows(count: int) -> str:
    return "1 row" if count == 1 else f"{count} rows"


def _trimmed(number: float, asked: float) -> float:
    """Six digits towards zero: what is printed passes, too. All where six are those of `asked`."""
    if number == 0.0 or not math.isfinite(number):
        return number
    unit = 10.0 ** (math.floor(math.log10(abs(number))) - 5)
    trimmed = math.trunc(number / unit * (1 + 1e-9)) * unit
    return number if f"{trimmed:g}" == f"{asked:g}" else trimmed


def _line(name: str, text: str) -> str:
    return f"  {name:<7} {text}"


TESTS = "build/safety/fairlead-safety-tests --test-case='*{}*'"
PAGE = "docs/safety-checks.md"


def check_lines(code: int) -> list[str]:
    """The check's item of the list in docs/safety-checks.md, and what to do about it."""
    check, name = CHECKS[code], f"G{code:03d}"
    said = {
        "hazard": check.hazard,
        "passes": check.rule,
        "unit": ", ".join("a plain number" if unit == "1" else unit for unit in check.units),
        "else": check.outcome,
        "example": example_text(code),
        "do": check.hint,
        "more": f"{PAGE}, {check.section}" if check.section else PAGE,
        "tests": TESTS.format(name),
    }
    return [f"{name} {check.title}", *(f"  {key:<7} {text}" for key, text in said.items() if text)]
