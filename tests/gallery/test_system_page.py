"""Tests of pages of systems: their tables are those of Drake's systems."""

import re

import numpy as np
import pytest
from pydrake.systems.framework import Context, LeafSystem

from aerodrake.gallery.export import gallery
from aerodrake.gallery.graph import systems_by_name
from aerodrake.gallery.ports import input_ports, output_ports
from aerodrake.gallery.system_page import system_page
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop
from tests.modules import PACKAGE

SYSTEMS = systems_by_name(make_closed_loop(Scenario()))
OURS = [name for name, s in SYSTEMS.items() if type(s).__module__.startswith("aerodrake")]


def table(page: str, title: str) -> list[dict[str, str]]:
    """The rows of a section's table."""
    section = re.search(rf"^## {title}$(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)
    lines = [line for line in section[1].splitlines() if line.startswith("| ")] if section else []
    cells = [[cell.strip() for cell in line[1:-1].split(" | ")] for line in lines]
    return [dict(zip(cells[0], row, strict=True)) for row in cells[2:]]


@pytest.mark.parametrize("name", SYSTEMS)
def test_ports_are_those_of_the_system(name):
    system, page = SYSTEMS[name], system_page(name, SYSTEMS[name], 1)
    for title, get, count in (
        ("Inputs", system.get_input_port, system.num_input_ports()),
        ("Outputs", system.get_output_port, system.num_output_ports()),
    ):
        shown = {row["port"].strip("`"): row["size"] for row in table(page, title)}
        ports = map(get, range(count))
        has = {port.get_name(): port.size() for port in ports}
        assert {port: int(size) for port, size in shown.items() if size != "abstract"} == {
            port: size for port, size in has.items() if size
        }
        assert all(has[port] == 0 for port, size in shown.items() if size == "abstract")


@pytest.fixture(scope="module")
def packaged():
    """Every system of the package and of the packaged scenarios' diagrams, by name and class."""
    found = {(name, type(system).__name__): system for name, system in gallery().items()}
    for path in sorted((PACKAGE / "scenarios").glob("*.yaml")):
        for name, system in systems_by_name(make_closed_loop(load_scenario(path.stem))).items():
            found.setdefault((name, type(system).__name__), system)
    return found


def test_every_port_has_a_meaning_of_its_own(packaged):
    assert len(packaged) > 40
    for (name, _), system in packaged.items():
        page = system_page(name, system, 1)
        rows = table(page, "Inputs") + table(page, "Outputs")
        ports = input_ports(system) + output_ports(system)
        assert [row["port"].strip("`") for row in rows] == [port.get_name() for port in ports]
        for row in rows:
            assert row["meaning"], f"{name}.{row['port']}"
            referring = r"^(the same|those|likewise|as (in|of|received)|that of|inputs? of)\b"
            assert not re.match(referring, row["meaning"]), f"{name}.{row['port']}"


def test_pages_do_not_speak_of_subclasses(packaged):
    for (name, _), system in packaged.items():
        page = system_page(name, system, 1)
        text = page.partition("## Equations")[0]
        assert not re.search(r"subclass|(hose|hat) of `[A-Z][a-z]", text), name


@pytest.mark.parametrize("name", OURS)
def test_state_and_equations(name):
    system, page = SYSTEMS[name], system_page(name, SYSTEMS[name], 1)
    sizes = [int(row["size"]) for row in table(page, "State")]
    assert sum(sizes) == system.CreateDefaultContext().num_total_states()
    assert "## Equations" in page and "in `aerodrake/model/" in page


@pytest.mark.parametrize("name", OURS)
def test_discrete_groups_have_names(name):
    groups = [row["discrete group"] for row in table(system_page(name, SYSTEMS[name], 1), "State")]
    assert all(re.fullmatch(r"`[a-zA-Z]\w*(\.\w+)*`", group) for group in groups)
    assert len(groups) == len(set(groups))


def test_discrete_groups_are_fields_or_attributes():
    rows = table(system_page("mpc", SYSTEMS["mpc"], 1), "State")
    sizes = {row["discrete group"].strip("`"): int(row["size"]) for row in rows}
    assert sizes["u"] == 9 and sizes["status"] == 3 and sizes["delta"] == 3
    rows = table(system_page("weight_allocator", SYSTEMS["weight_allocator"], 1), "State")
    assert rows == [{"discrete group": "`mode`", "size": "1"}]


def test_direct_feedthrough_is_shown():
    rows = table(system_page("mpc", SYSTEMS["mpc"], 1), "Outputs")
    assert all("feeds through from" not in row for row in rows)
    (row,) = table(system_page("weight_allocator", SYSTEMS["weight_allocator"], 1), "Outputs")
    assert row["feeds through from"] == "`distances`, `d_g`"


def test_rates():
    page = system_page("closed_loop", SYSTEMS["closed_loop"], 2)
    rates = {row["system"].strip("`"): (row["every"], row["after"]) for row in table(page, "Rates")}
    assert rates["mpc"] == ("20 ms", "") and rates["multibody_plant"] == ("1 ms", "")
    assert rates["flight_controller"] == ("10 ms", "0.5 ms")
    page = system_page("arm_controller", SYSTEMS["arm_controller"], 1)
    assert "A discrete update every 5 ms, after 0.5 ms." in page


@pytest.mark.parametrize("pages", [(), ("mpc", "reference", "station")])
def test_links_lead_to_other_pages(pages):
    page = system_page("coordinator", SYSTEMS["coordinator"], 2, pages)
    assert set(re.findall(r"\]\((\w+)\.md\)", page)) == {"mpc", "reference"} & set(pages)
    (parts,) = re.findall(r"## Parts\n\n(.*)", page)
    assert {"mpc", "guidance", "reference"} <= set(re.findall(r"[`\[](\w+)[`\]]", parts))


@pytest.mark.parametrize(
    "name", ["closed_loop", "station", "coordinator", "physics", "plant", "wind"]
)
def test_connections_are_those_of_the_diagram(name):
    rows = table(system_page(name, SYSTEMS[name], 1), "Connections")
    assert len(rows) == len(SYSTEMS[name].connection_map())
    for (target, i), (source, o) in SYSTEMS[name].connection_map().items():
        ends = (source.get_name(), source.get_output_port(o).get_name())
        ends += (target.get_name(), target.get_input_port(i).get_name())
        assert tuple(f"`{end}`" for end in ends) in [tuple(row.values()) for row in rows]


def test_drakes_systems_name_their_maker():
    page = system_page("rotors", SYSTEMS["rotors"], 1)
    assert "made by `make_rotors` in `aerodrake/systems/rotors.py`" in page
    assert table(page, "State") == [{"discrete group": "`x`", "size": "4"}]


def test_a_users_own_system():
    class Filter(LeafSystem):
        """Half of it.

        Ports:
            in `x` (3): m.
            out `y` (3): m, half of x | or so.
        """

        def __init__(self):
            super().__init__()
            self.DeclareVectorInputPort("x", 3)
            self.DeclareVectorOutputPort("y", 3, self._calc)

        def _calc(self, context: Context, output) -> None:
            output.SetFromVector(np.zeros(3))

    own = Filter()
    own.set_name("half")
    page = system_page("half", own, 1)
    assert page.startswith("# half\n\n*A LeafSystem of `Filter` in `") and "Half of it." in page
    assert "| `y` | 3 | `x` | m, half of x \\| or so. |" in page
