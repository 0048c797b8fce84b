"""The chart of a closed loop: complete, without overlaps."""

import re
from itertools import combinations

import pytest

from aerodrake.gallery.graph import to_mermaid
from aerodrake.reports.loop_chart import SIDES, loop_chart
from aerodrake.scenario import RotorDegraded, SampleNan, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop

SCENARIOS = {
    "default": Scenario(),
    "clik": Scenario(controller="clik"),
    "faults": Scenario(
        faults=(RotorDegraded(1.0, 1.0, rotor=0, remaining=0.5), SampleNan(1.0, 1.0))
    ),
    "realistic": load_scenario("clover_realistic"),
    "pointing": load_scenario("clover_pointing"),
}


@pytest.fixture(scope="module", params=SCENARIOS.values(), ids=SCENARIOS)
def loop(request):
    return make_closed_loop(request.param)


@pytest.fixture(scope="module")
def chart(loop):
    return loop_chart(loop)


def name(box) -> str:
    return "".join(box.lines[: box.names])


def at(boxes, axis: str, place: float):
    (box,) = (box for box in boxes if getattr(box, axis) == place)
    return box


def test_each_system_is_on_the_diagonal(loop, chart):
    systems = [s for side in SIDES for s in loop.GetSubsystemByName(side).GetSystems()]
    assert [name(box) for box in chart.systems] == [s.get_name() for s in systems]
    for before, after in zip(chart.systems, chart.systems[1:], strict=False):
        assert before.x < after.x and before.y < after.y


def test_each_signal_is_in_the_row_of_its_source_and_the_column_of_its_target(loop, chart):
    """The same ends as the arrows of the Mermaid flowchart, which is made separately."""
    shown = {
        (name(at(chart.systems, "y", box.y)), name(at(chart.systems, "x", box.x)))
        for box in chart.signals
    }
    arrows = re.findall(r"(?m)^ +(\w+) -->(?:\|.*\|)? (\w+)$", to_mermaid(loop, 2))
    assert shown == {ends for ends in arrows if not set(ends) & {"samples", "log"}}
    for line in chart.lines:
        source, target = (at(chart.systems, *end) for end in (("y", line.y), ("x", line.to_x)))
        assert (line.x, line.to_y) == (source.x, target.y)


def test_boxes_do_not_overlap(chart):
    for a, b in combinations(chart.systems + chart.signals, 2):
        apart_x = abs(a.x - b.x) - (a.width + b.width) / 2
        apart_y = abs(a.y - b.y) - (a.height + b.height) / 2
        assert max(apart_x, apart_y) > 0


def test_everything_is_inside(chart):
    for box in chart.systems + chart.signals + chart.sides:
        assert box.width / 2 <= box.x <= chart.width - box.width / 2
        assert box.height / 2 <= box.y <= chart.height - box.height / 2


@pytest.mark.parametrize(
    ("scenario", "system", "inside"),
    [
        ("default", "guidance", ("reference", "reference_guard")),
        ("faults", "sensors", ("sensor_noise", "sampler", "state_filter", "sample_nan_1")),
    ],
)
def test_systems_inside_a_system_are_named(scenario, system, inside):
    boxes = loop_chart(make_closed_loop(SCENARIOS[scenario])).systems
    (box,) = (box for box in boxes if name(box) == system)
    assert box.lines[box.names :] == inside


@pytest.mark.parametrize(
    ("scenario", "there", "not_there"), [("clik", "clik", "mpc"), ("pointing", "pointing", "clik")]
)
def test_it_shows_the_systems_of_the_scenario(scenario, there, not_there):
    names = {name(box) for box in loop_chart(make_closed_loop(SCENARIOS[scenario])).systems}
    assert there in names and not_there not in names
