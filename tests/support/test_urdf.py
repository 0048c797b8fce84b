"""Malformed and hostile robot descriptions are refused."""

import os

import pytest

from aerodrake.support.errors import BadInput
from aerodrake.support.urdf import MAX_BYTES, MAX_DEPTH, copy_urdf, read_urdf


def mesh(file: str) -> str:
    """Returns a URDF with one mesh."""
    geometry = f'<geometry><mesh filename="{file}"/></geometry>'
    return f'<robot><link name="arm"><visual>{geometry}</visual></link></robot>'


ENTITIES = "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 10}">' for i in range(9))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (f'<!DOCTYPE robot [<!ENTITY a0 "lol">{ENTITIES}]><robot>&a9;</robot>', "no document type"),
        (
            '<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot>&a;</robot>',
            "no docum",
        ),
        ('<!DOCTYPE robot SYSTEM "http://localhost/x.dtd"><robot/>', "no document type"),
        ("<robot>" + "<a>" * MAX_DEPTH + "</a>" * MAX_DEPTH + "</robot>", "more than 50 levels"),
        ("<robot>" + " " * MAX_BYTES + "</robot>", "at most 5000000 bytes"),
        ("<sdf/>", "whose root is <robot>"),
        ("{}", "not well-formed"),
        ('<?xml version="1.0" encoding="nonsense"?><robot/>', "unknown encoding"),
        (mesh("folder"), "link arm, visual: <mesh filename>: .* got 'folder', which is no file"),
        (mesh("pipe.obj"), "got 'pipe.obj', which is no file"),
        (mesh("none.obj"), "got 'none.obj', which does not exist"),
        (mesh("n" * 300), "which does not exist"),
        (mesh(""), "got '', which is no file"),
        (mesh("package://other/arm.obj"), "which is of another package or scheme"),
        (mesh("package://aerodrake/../setup.py"), "which is of another package or scheme"),
        (mesh("http://localhost/arm.obj"), "which is of another package or scheme"),
        (mesh("package://aerodrake/none.obj"), "which does not exist"),
        ('<robot><material><texture filename="t.png"/></material></robot>', "t.png', which does"),
        ('<robot xmlns:xacro="x"><xacro:include/></robot>', "expand the macros with .* `xacro`"),
    ],
)
def test_hostile_descriptions_are_refused(tmp_path, text, problem):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe.obj")
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(BadInput, match=problem):
        read_urdf(path)


def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "robot.urdf")
    with pytest.raises(BadInput, match="got a pipe"):
        read_urdf(tmp_path / "robot.urdf")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("robot.sdf", "robot.sdf: expected a URDF, .*; other formats have to be converted"),
        ("robot.urdf.xacro", "expand it with `xacro robot.urdf.xacro > robot.urdf`"),
        ("robot", "whose name ends in .urdf$"),
    ],
)
def test_other_endings_are_refused(name, problem, tmp_path):
    (tmp_path / name).write_text("<robot/>")
    with pytest.raises(BadInput, match=problem):
        read_urdf(tmp_path / name)


def test_capitals_of_the_ending_and_unused_definitions_of_xacro_do_not_matter(tmp_path):
    path = tmp_path / "ROBOT.URDF"
    path.write_text('<robot><xacro:property name="w" value="1"/><xacro:arg name="x"/></robot>')
    assert read_urdf(path).documentElement.tagName == "robot"


def test_meshes_and_textures_are_copied_and_other_elements_are_not_read(tmp_path):
    (tmp_path / "parts").mkdir()
    for name in ("arm.obj", "arm.mtl", "skin.png"):
        (tmp_path / "parts" / name).write_text(name)
    text = mesh("parts/arm.obj").replace(
        "</robot>",
        '<material name="skin"><texture filename="parts/skin.png"/></material>'
        '<gazebo><mesh filename="none.obj"/></gazebo></robot>',
    )
    (tmp_path / "robot.urdf").write_text(text)
    (tmp_path / "copy").mkdir()
    copy_urdf(tmp_path / "robot.urdf", tmp_path / "copy" / "robot.urdf")
    copies = {path.name: path.read_text() for path in (tmp_path / "copy").rglob("*.???")}
    assert all(copies[name] == name for name in ("arm.obj", "arm.mtl", "skin.png"))
    document = read_urdf(tmp_path / "copy" / "robot.urdf")
    for tag in ("mesh", "texture"):
        file = document.getElementsByTagName(tag)[0].getAttribute("filename")
        assert file.startswith(f"file://{tmp_path / 'copy'}/robot-meshes/")
