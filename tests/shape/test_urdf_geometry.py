"""Geometry from the ``<collision>`` elements of a URDF."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.messages import FloatArray
from fairlead.robot.manifest import load_robot
from fairlead_tools.shape.geometry import geometry_source
from fairlead_tools.shape.robot_shape import RobotShape
from tests.shape.own_robot import NAME, own_robot

LINK = '<link name="panda_link1"/>'


def shape_of(
    geometry: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, origin: str = ""
) -> RobotShape:
    """The shape of a robot whose link 1 has one collision element, and no model."""
    collision = f"<collision>{origin}<geometry>{geometry}</geometry></collision>"
    link = LINK.replace("/>", f">{collision}</link>")
    folder = own_robot(tmp_path, monkeypatch, urdf=(LINK, link))
    (folder / "mine.xml").unlink()
    tetrahedron(folder / "solid.stl")
    robot = load_robot(NAME).model_copy(update={"home": None})
    return RobotShape(robot, geometry_source(robot, None))


def tetrahedron(path: Path) -> None:
    """A binary STL file: the origin and a point on each axis, 0.1, 0.2 and 0.3 m out."""
    corners = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]], dtype="<f4")
    faces = [corners[list(face)] for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    blocks = [np.zeros(3, "<f4").tobytes() + face.tobytes() + b"\0\0" for face in faces]
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(blocks)) + b"".join(blocks))


def extent(shape: RobotShape) -> FloatArray:
    """Lowest and highest coordinates of the only link with geometry."""
    ((link, (piece,)),) = shape.geometry.items()
    assert link == "panda_link1"
    low, high = piece.points.min(axis=0) - piece.radius, piece.points.max(axis=0) + piece.radius
    return np.stack([low, high])


@pytest.mark.parametrize(
    ("geometry", "low", "high"),
    [
        ('<box size="0.2 0.4 0.6"/>', [-0.1, -0.2, -0.3], [0.1, 0.2, 0.3]),
        ('<sphere radius="0.25"/>', [-0.25] * 3, [0.25] * 3),
        ('<cylinder radius="0.1" length="0.6"/>', [-0.1, -0.1, -0.3], [0.1, 0.1, 0.3]),
        ('<mesh filename="solid.stl"/>', [0.0, 0.0, 0.0], [0.1, 0.2, 0.3]),
        ('<mesh filename="solid.stl" scale="2 1 1"/>', [0.0, 0.0, 0.0], [0.2, 0.2, 0.3]),
    ],
)
def test_every_shape_is_as_large_as_it_says(
    geometry: str,
    low: list[float],
    high: list[float],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = extent(shape_of(geometry, tmp_path, monkeypatch))
    np.testing.assert_allclose(found, [low, high], atol=5e-4)


def test_the_origin_turns_about_fixed_axes_and_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # First a quarter about x, then one about z: the box's z becomes -y and then x.
    turned = f'<origin xyz="1 2 3" rpy="{np.pi / 2} 0 {np.pi / 2}"/>'
    shape = shape_of('<box size="0.2 0.4 0.6"/>', tmp_path, monkeypatch, turned)
    wanted = [[1 - 0.3, 2 - 0.1, 3 - 0.2], [1 + 0.3, 2 + 0.1, 3 + 0.2]]
    np.testing.assert_allclose(extent(shape), wanted, atol=1e-6)


def test_a_capsule_of_it_holds_the_mesh_and_rests_at_zero(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shape = shape_of('<mesh filename="solid.stl"/>', tmp_path, monkeypatch)
    (capsule,) = shape.fitted(1)
    a, b = np.array(capsule.a_m), np.array(capsule.b_m)
    for corner in np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]]):
        shares = np.linspace(0.0, 1.0, 20_001)[:, None]
        assert (
            np.linalg.norm(a + shares * (b - a) - corner, axis=1).min() <= capsule.radius_m + 1e-7
        )
    assert float(shape.rest()["panda_joint1"][0]) == 0.0
    assert float(shape.rest()["panda_joint4"][0]) == -0.0698  # 0 is beyond its limit


@pytest.mark.parametrize(
    ("geometry", "complaint"),
    [
        ('<cone radius="1"/>', "expected a shape, got cone (valid: box, cylinder, sphere, mesh)"),
        ('<box size="1 2"/>', "size: expected 3 numbers, got '1 2'"),
        ('<sphere radius="nan"/>', "radius: expected 1 numbers, got 'nan'"),
        ('<mesh filename="lost.stl"/>', "no mesh file "),
        ('<mesh filename="solid.dae"/>', "expected a mesh (.obj, .stl), got "),
        ('<mesh filename="solid.dae"/>', "solid.dae; convert it to one of these, and name that"),
    ],
)
def test_what_cannot_be_read_is_told_with_its_link(
    geometry: str, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ConfigError) as error:
        shape_of(geometry, tmp_path, monkeypatch)
    assert "panda.urdf: collision of link 'panda_link1'" in str(error.value)
    assert complaint in str(error.value)


def test_a_description_without_geometry_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    (folder / "mine.xml").unlink()
    with pytest.raises(
        ConfigError,
        match=r"no link has a <collision>; name its MuJoCo model: --mjcf FILE of robot new",
    ):
        geometry_source(load_robot(NAME), None)


def test_a_body_that_moves_without_being_a_link_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = '<body name="panda_link5"'
    flap = f'<body name="flap"><joint/><geom size="0.1" mass="1"/></body>{link}'
    own_robot(tmp_path, monkeypatch, xml=(link, flap))
    model = tmp_path / NAME / "mine.xml"
    model.write_text(re.sub(r"<key [^>]*/>", "", model.read_text()))
    with pytest.raises(ConfigError, match=r"body 'flap' moves on link 'panda_link4'"):
        geometry_source(load_robot(NAME), None)


def test_a_frame_of_a_body_that_is_not_there_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_robot(tmp_path, monkeypatch, yaml=("body:panda_link3", "body:elbow"))
    with pytest.raises(
        ConfigError, match="expected a body of the model for frame panda_link3, got 'elbow'"
    ):
        geometry_source(load_robot(NAME), None)
