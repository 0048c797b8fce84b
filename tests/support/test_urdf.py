"""Malformed and hostile robot descriptions are refused."""

import os

import pytest

from aerodrake.support.errors import BadInput
from aerodrake.support.urdf import MAX_BYTES, MAX_DEPTH, read_urdf

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
        ('<robot><mesh filename="folder"/></robot>', "folder to be a mesh"),
        ('<robot><mesh filename="pipe.obj"/></robot>', "pipe.obj to be a mesh"),
    ],
    ids=["bomb", "entity", "dtd", "deep", "long", "sdf", "json", "encoding", "folder", "pipe"],
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
    with pytest.raises(BadInput, match="expected the path of a URDF"):
        read_urdf(tmp_path / "robot.sdf")
