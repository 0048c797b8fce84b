"""Files of pages and graphs: complete, and the committed ones up to date."""

import shutil
from pathlib import Path

import pytest
from pydrake.systems.primitives import Gain

from aerodrake.gallery import export as gallery
from aerodrake.gallery.docstring import Docstring
from aerodrake.gallery.export import export, graph
from aerodrake.gallery.graph import to_dot, to_mermaid
from aerodrake.gallery.system_page import system_page
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput
from tests.modules import SYSTEMS

GRAPHS = Path(__file__).parents[2] / "diagrams" / "graphs"
REDRAW = "aerodrake graph --out diagrams/graphs"
DEPTH = 2
"""Depth of the committed graphs, and default of the command."""
SUFFIXES = ("md", "dot", "mmd")
"""Suffixes of the files with Graphviz and without it."""


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
    ("names", "loops"), [(["mpc"], 1), (["mpc", "pointing"], 2), (["clik"], 3), (["staton"], 3)]
)
def test_no_more_is_built_than_needed(names, loops, monkeypatch):
    built = []

    def make(scenario):
        built.append(scenario)
        return make_closed_loop(scenario)

    monkeypatch.setattr(gallery, "make_closed_loop", make)
    systems = gallery.gallery(names)
    assert len(built) == loops
    assert all(name in systems for name in names) == (names != ["staton"])


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(BadInput, match="file: cannot be written"):
        graph(Gain(1.0, 1), tmp_path / "file")


def test_export_without_graphviz(systems, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    written = graph([systems["station"], systems["mpc"]], str(tmp_path / "a" / "b"), DEPTH)
    expected = [f"{name}.{suffix}" for name in ("station", "mpc") for suffix in SUFFIXES]
    assert [path.name for path in written] == expected
    assert sorted(written) == sorted((tmp_path / "a" / "b").iterdir())


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
    always = [f"small.{suffix}" for suffix in SUFFIXES]
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
        expected[f"{name}.md"] = system_page(name, system, DEPTH)
        expected[f"{name}.dot"] = to_dot(system, DEPTH)
        expected[f"{name}.mmd"] = to_mermaid(system, DEPTH)
    paths = [path for suffix in SUFFIXES for path in GRAPHS.glob(f"*.{suffix}")]
    committed = {path.name: path.read_text(encoding="utf-8") for path in paths}
    names = sorted(expected | committed)
    stale = [name for name in names if expected.get(name) != committed.get(name)]
    assert not stale, f"in {GRAPHS}, stale, missing or left over: {stale}; run: {REDRAW}"


def test_every_system_of_ours_has_a_page(systems):
    """Except those of the link between two processes, which no scenario has."""
    kinds = {type(system).__name__ for system in systems.values()}
    ours = {kind.__name__ for kind in SYSTEMS}
    abstract = {"KinematicController"}
    # Named as the systems that they replace.
    faulty = {"FaultyMpc", "FaultyResidualEstimator"}
    assert ours - kinds == {"WireReceiver", "WireSender"} | abstract | faulty


def test_every_port_of_a_system_is_documented(systems):
    ours = [system for system in systems.values() if type(system) in SYSTEMS]
    assert len(ours) > 15
    for system in ours:
        documented = {key for kind in type(system).__mro__ for key in Docstring.of(kind).ports}
        ports = {
            ("in", system.get_input_port(i).get_name()) for i in range(system.num_input_ports())
        }
        ports |= {
            ("out", system.get_output_port(i).get_name()) for i in range(system.num_output_ports())
        }
        assert ports <= documented, type(system).__name__
