"""Datasets: what is written is read again, and what is none is said to be none."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.learn.dataset import (
    add,
    begin,
    episodes,
    read_header,
    require_skill,
    same_kind,
)
from fairlead_tools.learn.lerobot_export import export_lerobot
from tests.cli.command import fairlead_here
from tests.learn.drawn import EXPERT, drawn_dataset, drawn_episode


def test_episodes_come_back_bit_for_bit_in_their_order(tmp_path: Path) -> None:
    written = [drawn_episode(7), drawn_episode(3, 5, succeeded=False)]
    folder = drawn_dataset(tmp_path / "d", *written)
    header = read_header(folder)
    assert [(one.seed, one.ticks, one.succeeded) for one in header.episodes] == [
        (7, 12, True),
        (3, 5, False),
    ]
    assert header.skill_hash == EXPERT.skill_hash.hex()
    for one, back in zip(written, episodes(folder), strict=True):
        for name in ("states", "rows", "acted"):
            assert getattr(back, name).tobytes() == getattr(one, name).tobytes()
            assert getattr(back, name).dtype == getattr(one, name).dtype


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(ConfigError, match="expected a folder that is new or empty"):
        begin(tmp_path, EXPERT, "panda_mobile", 0.0)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_dataset_without_episodes_is_begun_again(tmp_path: Path) -> None:
    begin(tmp_path, EXPERT, "panda_mobile", 0.0)
    header = begin(tmp_path, EXPERT, "panda_mobile", 0.5)
    assert read_header(tmp_path) == header and header.noise == 0.5
    add(tmp_path, header, drawn_episode(1))
    with pytest.raises(ConfigError, match="expected a folder that is new or empty"):
        begin(tmp_path, EXPERT, "panda_mobile", 0.0)


def test_of_two_that_record_into_one_folder_one_ends(tmp_path: Path) -> None:
    ends, other = [begin(tmp_path, EXPERT, "panda_mobile", 0.5) for _ in range(2)]
    add(tmp_path, other, drawn_episode(1))
    with pytest.raises(ConfigError, match="expected nobody else to record into it, got what "):
        add(tmp_path, ends, drawn_episode(1, 5))
    assert [len(one.states) for one in episodes(tmp_path)] == [12], "the other's is whole"


def with_words(old: bytes, new: bytes) -> Callable[[bytes], bytes]:
    return lambda data: data.replace(old, new, 1)


def saved(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def of_another_length(data: bytes) -> bytes:
    one = drawn_episode(7, 4)
    return saved(states=one.states, rows=one.rows, acted=one.acted)


def flipped(data: bytes) -> bytes:
    data = saved(states=drawn_episode(7).states)
    return data[:300] + bytes(byte ^ 0x5A for byte in data[300:1200]) + data[1200:]


def one_array(data: bytes) -> bytes:
    file = io.BytesIO()
    np.save(file, np.zeros(3))
    return file.getvalue()


def encrypted(data: bytes) -> bytes:
    flags = data.index(b"PK\1\2") + 8
    return data[:flags] + bytes([data[flags] | 1]) + data[flags + 1 :]


def huge(data: bytes) -> bytes:
    file, stated = io.BytesIO(), io.BytesIO()
    form = {"descr": "<f8", "fortran_order": False, "shape": (12, 10**14)}
    np.lib.format.write_array_header_1_0(stated, form)
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("states.npy", stated.getvalue())
    return file.getvalue()


@pytest.mark.parametrize(
    ("name", "damaged"),
    [
        ("dataset.json", lambda data: b"{"),
        ("dataset.json", with_words(b"mobile", b"\xff")),
        ("dataset.json", with_words(b'"meaning": {', b'"meaning": {"x":' + b"[" * 9999)),
        ("episode_000007.npz", lambda data: data[:100]),
        ("episode_000007.npz", lambda data: b""),
        ("episode_000007.npz", lambda data: saved(states=np.array([{}]))),
        ("episode_000007.npz", of_another_length),
        ("episode_000007.npz", flipped),
        ("episode_000007.npz", one_array),
        ("episode_000007.npz", encrypted),
        ("episode_000007.npz", huge),
    ],
)
def test_what_is_no_dataset_is_one_error_with_the_file(
    name: str, damaged: Callable[[bytes], bytes], tmp_path: Path
) -> None:
    file = drawn_dataset(tmp_path / "d", drawn_episode(7)) / name
    file.write_bytes(damaged(file.read_bytes()))
    with pytest.raises(ConfigError, match=re.escape(str(file))):
        list(episodes(tmp_path / "d"))
    file.unlink()
    with pytest.raises(ConfigError, match=re.escape(str(file))):
        list(episodes(tmp_path / "d"))


def test_datasets_of_different_layouts_do_not_go_together(tmp_path: Path) -> None:
    one, other = (drawn_dataset(tmp_path / name, drawn_episode(1)) for name in "ab")
    text = (other / "dataset.json").read_text().replace("mobile_pick_30d", "libero")
    (other / "dataset.json").write_text(text)
    assert same_kind([one, one]).layout == "mobile_pick_30d"
    with pytest.raises(ConfigError, match="dataset .*b: expected one of .* got .*libero"):
        same_kind([one, other])


def changed(change: Callable[[dict[str, Any]], None]) -> SkillManifest:
    document = EXPERT.model_dump(mode="json", exclude_defaults=True)
    change(document)
    return SkillManifest.model_validate(document)


def in_map(document: dict[str, Any]) -> None:
    document["state_contract"]["bindings"]["world_frame"] = "map"


def with_a_sign(document: dict[str, Any]) -> None:
    document["state_contract"]["bindings"]["quaternion_signs"] = {"eef_frame": "+x"}


def twice_as_fast(document: dict[str, Any]) -> None:
    slot = document["action_contract"]["slots"][0]
    slot["scale"] = [2 * one for one in slot["scale"]]


def turned(document: dict[str, Any]) -> None:
    eye = {"camera": "robot0_eye_in_hand", "width": 64, "height": 64}
    document["images"] = {"eye": eye | {"transforms": [{"rotate_deg": 180}]}}


def upright(document: dict[str, Any]) -> None:
    turned(document)
    del document["images"]["eye"]["transforms"]


BOUND = "state_contract.bindings"


@pytest.mark.parametrize(
    ("one", "other", "lines"),
    [
        (dict, in_map, [f"{BOUND}.world_frame: expected odom, got nothing"]),
        (dict, with_a_sign,
         [f"{BOUND}.quaternion_signs: expected nothing, got {{'eef_frame': '+x'}}"]),
        (dict, twice_as_fast,
         [f"slots.0.scale.{i}: expected 0.05, got 0.1" for i in range(3)]
         + [f"slots.0.scale.{i}: expected 0.5, got 1.0" for i in range(3, 6)]),
        (upright, turned,
         ["images.eye.transforms: expected nothing, got [{'rotate_deg': 180}]"]),
    ],
)  # fmt: skip
def test_datasets_whose_numbers_mean_others_do_not_go_together(
    tmp_path: Path,
    one: Callable[[dict[str, Any]], None],
    other: Callable[[dict[str, Any]], None],
    lines: list[str],
) -> None:
    folders = [tmp_path / "one", tmp_path / "other"]
    for folder, change in zip(folders, (one, other), strict=True):
        begin(folder, changed(change), "panda_mobile", 0.0)
    with pytest.raises(ConfigError) as caught:
        same_kind(folders)
    assert str(caught.value).splitlines() == [
        f"dataset {folders[1]}: its numbers mean others than those of dataset {folders[0]}:",
        *(f"  {line}" for line in lines),
    ]


def test_a_clone_s_round_goes_together_with_its_expert_s(tmp_path: Path) -> None:
    """Slots of a clone clip and decide, its policy is another, its rows are used one after one."""

    def cloned(document: dict[str, Any]) -> None:
        document |= {"id": "clone", "policy": {"backend": "onnx"}, "execute_steps": 1}
        document["action_contract"]["slots"][0]["clip"] = [-1.0, 1.0]
        document["action_contract"]["slots"][1]["threshold"] = 0.0

    begin(tmp_path / "one", EXPERT, "panda_mobile", 0.0)
    begin(tmp_path / "two", changed(cloned), "panda_mobile", 0.0)
    assert same_kind([tmp_path / "one", tmp_path / "two"]).skill == EXPERT.id
    require_skill(tmp_path / "two", EXPERT)


def test_a_dataset_that_does_not_say_what_its_numbers_mean_teaches_nothing(tmp_path: Path) -> None:
    file = drawn_dataset(tmp_path, drawn_episode(1)) / "dataset.json"
    older = json.loads(file.read_text())
    del older["meaning"]
    file.write_text(json.dumps(older))
    assert len(read_header(tmp_path).episodes) == 1
    with pytest.raises(ConfigError, match="expected one that says what .* record it again"):
        same_kind([tmp_path])


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"states": np.full((12, 30), np.inf)}, "states: expected finite numbers, got inf in"),
        ({"rows": np.full((12, 12), np.nan, np.float32)}, "rows: expected finite numbers, got nan"),
        ({"rows": np.array([["x"] * 12] * 12)}, "rows: expected float32 [12, N], got <U1 [12, 12"),
        ({"acted": np.zeros((12, 2, 2))}, "acted: expected float32 [12, 12], got float64 [12, 2"),
        ({"rows": np.zeros((12, 99), np.float32)},
         "acted: expected float32 [12, 99], got float32 [12, 12]"),
        ({"states": np.zeros((12, 0))}, "states: expected float64 [12, N], got float64 [12, 0]"),
        ({"labels": np.full((12, 8, 12), np.nan, np.float32)},
         "labels: expected finite numbers, got nan in tick 0"),
        ({"labels": np.zeros((12, 8, 5), np.float32)},
         "labels: expected float32 [12, N, 12], got float32 [12, 8, 5]"),
        ({"released": np.array(["x"] * 12)}, "released: expected bool [12], got <U1 [12]"),
        ({"picture_eye": np.zeros((12, 4, 4, 4), np.uint8)},
         "picture_eye: expected uint8 [12, N, N, 3], got uint8 [12, 4, 4, 4]"),
        ({"picture_eye": np.zeros((12, 0, 4, 3), np.uint8)},
         "picture_eye: expected uint8 [12, N, N, 3], got uint8 [12, 0, 4, 3]"),
    ],
)  # fmt: skip
def test_numbers_that_are_none_of_an_episode_are_refused_by_file_and_name(
    arrays: dict[str, Any], said: str, tmp_path: Path
) -> None:
    folder = drawn_dataset(tmp_path / "d", drawn_episode(0))
    file, header = folder / "episode_000000.npz", json.loads((folder / "dataset.json").read_text())
    header["expert"] = "x" if "labels" in arrays else ""
    header["deployed"] = "released" in arrays
    header["pictures"] = [name[8:] for name in arrays if name.startswith("picture_")]
    (folder / "dataset.json").write_text(json.dumps(header))
    with np.load(file) as kept:
        np.savez(file, **{**kept, **arrays})
    with pytest.raises(ConfigError, match=re.escape(f"dataset: {file}: {said}")):
        list(episodes(folder))


def test_numbers_of_another_skill_are_refused_by_file_and_name(tmp_path: Path) -> None:
    folder = drawn_dataset(tmp_path / "d", drawn_episode(0))
    file = folder / "episode_000000.npz"
    with np.load(file) as kept:
        np.savez(file, **{**kept, "states": np.zeros((12, 5))})
    with pytest.raises(ConfigError, match=re.escape(f"{file}: states: expected float64 [12, 30]")):
        export_lerobot(folder, tmp_path / "l", EXPERT, failed=True)


def test_a_recording_that_was_ended_at_once_has_nothing_to_learn_from(tmp_path: Path) -> None:
    folder = drawn_dataset(tmp_path / "d")
    words = ("train", str(folder), "--out", str(tmp_path / "mine"))
    done = fairlead_here(*words, state=tmp_path)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (
        1, f"ERROR train: expected episodes in {folder}, got none; see: fairlead dataset show",
    )  # fmt: skip
    assert not (tmp_path / "mine").exists()


@pytest.mark.parametrize(("field", "wrong"), [("rate_hz", 0), ("ticks", 0)])
def test_a_dataset_of_no_rate_or_of_an_episode_without_ticks_is_none(
    field: str, wrong: int, tmp_path: Path
) -> None:
    file = drawn_dataset(tmp_path / "d", drawn_episode(0)) / "dataset.json"
    file.write_text(re.sub(f'"{field}": [0-9.]+', f'"{field}": {wrong}', file.read_text()))
    with pytest.raises(ConfigError, match=f"^dataset: {file}: Expected .*{field}"):
        read_header(tmp_path / "d")
