"""Files of pages and graphs: complete, and the committed ones up to date."""

import re
import shutil
from pathlib import Path

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Gain

from aerodrake.gallery import export as gallery
from aerodrake.gallery import loops
from aerodrake.gallery.export import export, graph, texts
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput
from tests.modules import SYSTEMS

GRAPHS = Path(__file__).parents[2] / "diagrams" / "graphs"
REDRAW = "aerodrake graph --out diagrams/graphs"
DEPTH = 2
"""Depth of the committed graphs, and default of the command."""
SUFFIXES = (".md", ".dot", ".mmd")
"""Ends of the files' names, with Graphviz and without it."""


@pytest.fixture(scope="module")
def closed_loop():
    return make_closed_loop(Scenario())


@pytest.fixture(scope="module")
def systems():
    return gallery.gallery()


@pytest.mark.parametrize(
    ("given", "suggested"),
    [
        ("staton", "station"),
        ("MpcSystem", "mpc"),
        ("Closed-Loop", "closed_loop"),
        ("controller_flight", "flight_controller"),
        ("KinematicsSystem", "kinematics"),
        ("FlightController", "flight_controller"),
        ("sample_nan", "sample_nan_0"),
        ("mpc_fault", "faulty_mpc"),
        ("WireReceiver", "receiver"),
        ("remote coordinator", "remote_coordinator"),
    ],
)
def test_unknown_name(given, suggested, tmp_path, monkeypatch, systems):
    monkeypatch.setattr(gallery, "gallery", lambda names=(): systems)
    with pytest.raises(BadInput, match=rf"graph: .*'{given}'; did you mean '{suggested}'\?"):
        graph(["mpc", given], tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"systems": 3}, "expected the name of a system, a system, or several, got int"),
        ({"systems": [Scenario()]}, "expected the name of a system, .* got Scenario"),
        ({"depth": -1}, r"depth: expected a whole number in \[0, 100\], got -1"),
        ({"depth": True}, "depth: expected a whole number"),
        ({"depth": "2"}, "depth: expected a whole number"),
    ],
)
def test_arguments_of_the_wrong_kind(arguments, expected, tmp_path):
    with pytest.raises(BadInput, match=expected):
        graph(**{"systems": Gain(1.0, 1), "out": tmp_path / "out"} | arguments)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("names", "count"),
    [
        (["mpc"], 1),
        (["mpc", "pointing"], 2),
        (["setpoint_link"], 3),
        (["clik"], 4),
        (["receiver"], 5),
        (["staton"], 5),
    ],
)
def test_no_more_is_built_than_needed(names, count, monkeypatch):
    built = []

    def make(scenario):
        built.append(scenario)
        return make_closed_loop(scenario)

    monkeypatch.setattr(loops, "make_closed_loop", make)
    systems = gallery.gallery(names)
    assert len(built) == count
    assert all(name in systems for name in names) == (names != ["staton"])


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(BadInput, match="file: cannot be written"):
        graph(Gain(1.0, 1), tmp_path / "file")


def test_export_without_graphviz(systems, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    written = graph([systems["station"], systems["mpc"]], str(tmp_path / "a" / "b"), DEPTH)
    expected = [f"station{suffix}" for suffix in (*SUFFIXES, "_n2.svg")]
    assert [path.name for path in written] == expected + [f"mpc{suffix}" for suffix in SUFFIXES]
    assert sorted(written) == sorted((tmp_path / "a" / "b").iterdir())


@pytest.mark.parametrize(
    "names", [None, "mpc", "station", ["coordinator", "guidance"], ["remote_coordinator"]]
)
def test_links_lead_to_what_was_written(names, systems, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(gallery, "gallery", lambda names=(): systems)
    files = {path.name for path in graph(names, tmp_path / "out")}
    links = [
        link
        for page in (tmp_path / "out").glob("*.md")
        for link in re.findall(r"\]\(([^)]*)\)", page.read_text(encoding="utf-8"))
    ]
    assert set(links) <= files
    assert bool(links) == (names != "mpc")
    if names is None:
        assert {f"{name}.md" for name in systems} == {f for f in files if f.endswith(".md")}
        assert set(links) > {"wind_force.md", "receiver.md", "closed_loop_n2.svg"}


@pytest.mark.parametrize(("name", "file"), [("", "Gain"), ("my gain", "my_gain"), ("a/b", "a_b")])
def test_a_users_own_system_by_any_name(name, file, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    own = Gain(2.0, 1)
    own.set_name(name)
    assert {path.stem for path in graph(own, tmp_path)} == {file}


def test_a_users_own_diagram(tmp_path, monkeypatch):
    """It has no name, as diagrams usually, and its systems have names that no word is."""
    monkeypatch.setenv("PATH", str(tmp_path))
    builder = DiagramBuilder()
    first, second = (builder.AddNamedSystem(name, Gain(2.0, 1)) for name in ("a b", "c"))
    builder.AddSystem(Gain(1.0, 1))
    builder.Connect(first.get_output_port(), second.get_input_port())
    diagram = builder.Build()
    written = graph(diagram, tmp_path)
    assert [path.name for path in written] == [f"Diagram{s}" for s in (*SUFFIXES, "_n2.svg")]
    assert "| `a b` | `y0` | `c` | `u0` |" in written[0].read_text()
    with pytest.raises(BadInput, match="graph: expected systems with different names"):
        graph([diagram, diagram], tmp_path)


@pytest.mark.parametrize(
    ("script", "drawings"),
    [
        ("echo '<svg/>'", ["small.svg", "small.png"]),
        ("echo '<svg'; exit 1", []),
        ("while :; do :; done", []),
    ],
)
def test_export_with_a_graphviz_that_works_fails_or_hangs(script, drawings, tmp_path, monkeypatch):
    (tmp_path / "dot").write_text(f"#!/bin/sh\n{script}\n")
    (tmp_path / "dot").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    if not drawings:
        monkeypatch.setattr(gallery, "DOT_TIMEOUT_S", 0.5)
    small = Gain(2.0, 1)
    small.set_name("small")
    written = export("small", small, tmp_path, 1)
    always = [f"small{suffix}" for suffix in SUFFIXES]
    assert [path.name for path in written] == always + drawings


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
def test_graphviz_reads_what_is_written(closed_loop, tmp_path):
    *_, svg, png = export("closed_loop", closed_loop, tmp_path, DEPTH)
    assert (svg.name, png.name) == ("closed_loop.svg", "closed_loop.png")
    assert "setpoint_integrator" in svg.read_text()
    assert png.read_bytes().startswith(b"\x89PNG")


def test_committed_pages_and_graphs_are_up_to_date(systems):
    expected = {}
    for name, system in systems.items():
        expected |= texts(name, system, DEPTH, systems)
    paths = [path for suffix in (*SUFFIXES, "_n2.svg") for path in GRAPHS.glob(f"*{suffix}")]
    committed = {path.name: path.read_text(encoding="utf-8") for path in paths}
    names = sorted(expected | committed)
    stale = [name for name in names if expected.get(name) != committed.get(name)]
    assert not stale, f"in {GRAPHS}, stale, missing or left over: {stale}; run: {REDRAW}"


def test_every_system_of_ours_has_a_page(systems):
    kinds = {type(system).__name__ for system in systems.values()}
    assert {kind.__name__ for kind in SYSTEMS} - kinds == {"KinematicController"}  # A base class.
