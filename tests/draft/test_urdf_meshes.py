"""Which file a URDF's mesh is: of its own package and no other, however the name is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead_tools.draft.urdf_file import copied_urdf

FOO, BAR = Path("ws/src/foo_description"), Path("ws/src/bar_description")


def mesh(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def urdf_of(tmp_path: Path, *attributes: str) -> Path:
    """A URDF in foo_description that collides with the meshes of these attributes."""
    meshes = "".join(
        f"<link name='l{number}'><collision><geometry><mesh {attribute}/></geometry></collision>"
        "</link>"
        for number, attribute in enumerate(attributes)
    )
    return mesh(tmp_path / FOO / "urdf" / "arm.urdf", f"<robot>{meshes}</robot>")


def copied(tmp_path: Path, urdf: Path) -> tuple[str, dict[str, str]]:
    """The copy's text, and the meshes that lie beside it."""
    folder = tmp_path / "copy"
    folder.mkdir()
    text = copied_urdf(urdf, folder, with_meshes=True)
    return text, {one.name: one.read_text() for one in (folder / "meshes").iterdir()}


def test_a_mesh_of_a_package_beside_the_urdfs_own_is_not_the_own_one_of_its_path(
    tmp_path: Path,
) -> None:
    mesh(tmp_path / FOO / "meshes" / "a.stl", "foo's")
    mesh(tmp_path / BAR / "meshes" / "a.stl", "bar's")
    urdf = urdf_of(
        tmp_path,
        'filename="package://bar_description/meshes/a.stl"',
        'filename="package://foo_description/meshes/a.stl"',
    )
    text, meshes = copied(tmp_path, urdf)
    assert meshes == {"a.stl": "bar's", "1_a.stl": "foo's"}
    assert text.index('filename="meshes/a.stl"') < text.index('filename="meshes/1_a.stl"')


def test_a_mesh_of_a_package_that_is_not_there_is_refused_with_what_was_looked_for(
    tmp_path: Path,
) -> None:
    mesh(tmp_path / FOO / "meshes" / "a.stl", "foo's")
    named = "package://bar_description/meshes/a.stl"
    with pytest.raises(ConfigError) as refused:
        copied(tmp_path, urdf_of(tmp_path, f'filename="{named}"'))
    said = f"no mesh {named}: looked for meshes/a.stl in a folder bar_description, or one whose"
    assert said in str(refused.value)


def test_a_folder_of_another_name_is_the_package_that_its_package_xml_names(tmp_path: Path) -> None:
    mesh(tmp_path / FOO / "meshes" / "a.stl", "acme's")
    urdf = urdf_of(tmp_path, 'filename="package://acme/meshes/a.stl"')
    mesh(tmp_path / FOO / "package.xml", "<package><name> acme </name></package>")
    assert copied(tmp_path, urdf)[1] == {"a.stl": "acme's"}


def test_a_mesh_named_in_single_quotes_or_with_an_entity_is_named_in_the_copy(
    tmp_path: Path,
) -> None:
    mesh(tmp_path / FOO / "urdf" / "a&b.stl", "both")
    mesh(tmp_path / FOO / "urdf" / "one.stl", "one")
    urdf = urdf_of(tmp_path, "filename='one.stl'", 'filename = "a&amp;b.stl"')
    text, meshes = copied(tmp_path, urdf)
    assert meshes == {"a&b.stl": "both", "one.stl": "one"}
    assert 'filename="meshes/one.stl"' in text and 'filename = "meshes/a&amp;b.stl"' in text
