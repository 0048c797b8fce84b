"""Replacement of systems by the user's own."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.gallery.graph import systems_by_name
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.scenario import Clover, LearnerPoisoned, Residual, RotorDegraded, Scenario, Wind
from aerodrake.station import make_closed_loop, make_coordinator, make_station
from aerodrake.support.errors import BadInput
from aerodrake.wiring.replacements import Replacements

SHORT = Scenario(duration=0.3, settle_s=0.1, reference=Clover(start_s=0.2))
BREEZE = Wind(velocity_m_s=(1.0, 0.0, 0.0), gust_m_s=(0.5, 0.5, 0.5))
NAMES = sorted(systems_by_name(make_closed_loop(SHORT)).keys() - {"closed_loop"})


class Fixed(LeafSystem):
    """Weight allocator with constant weights."""

    def __init__(self, **sizes: int):
        super().__init__()
        for name, size in ({"d_g": 1, "distances": 2} | sizes).items():
            self.DeclareVectorInputPort(name, size)
        self.DeclareVectorOutputPort("weights", 5, self._calc, {self.nothing_ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([0.5, Mode.HOVER, 600.0, 20.0, 1.0])


def flown(scenario: Scenario, **by_name):
    return FlightSimulation(scenario, Replacements(by_name)).fly()


@pytest.fixture(scope="module")
def default():
    return flown(SHORT)


def test_a_replacement_flies(default):
    log = flown(SHORT, weight_allocator=lambda default: Fixed())
    assert log.exit_reason == "completed"
    ticked = slice(3, None)  # The first samples are from before the first tick.
    np.testing.assert_array_equal(log["gamma"][ticked], 0.5)
    np.testing.assert_array_equal(log["w_m"][ticked], 20.0)
    assert not np.array_equal(log["q_rad"], default["q_rad"])


class Gale(LeafSystem):
    """Constant wind."""

    def __init__(self):
        super().__init__()
        self.DeclareVectorInputPort("u0", 3)
        self.DeclareVectorOutputPort("y0", 3, self._calc, {self.nothing_ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([2.0, 0.0, 0.0])


def test_replaced_air_acts_in_a_scenario_without_wind(default):
    """0.25 |v| v + 0.15 v; less with the drift of the base."""
    log = flown(SHORT, air=lambda default: Gale())
    np.testing.assert_allclose(log["wind_force_n"][-1], [1.3, 0, 0], atol=0.1)
    np.testing.assert_array_equal(default["wind_force_n"], 0.0)


def test_a_replacement_is_used_in_one_diagram():
    fixed = Fixed()
    mine = Replacements({"weight_allocator": lambda default: fixed})
    make_closed_loop(SHORT, mine)
    with pytest.raises(BadInput, match="weight_allocator: expected a new system, got one of a"):
        make_closed_loop(SHORT, mine)


@pytest.mark.parametrize("name", NAMES)
def test_every_system_can_be_replaced(name):
    """Sub-diagrams too; a function may return the default system."""
    given = []

    def same(system):
        given.append(system.get_name())
        return system

    replacements = Replacements({name: same})
    diagram = make_closed_loop(SHORT, replacements)
    assert len(given) == 1 and given[0] in (name, "")
    assert name in systems_by_name(diagram)


def test_replacing_all_systems_by_themselves_changes_nothing(default):
    log = flown(SHORT, **{name: lambda system: system for name in NAMES})
    for key in set(log.signals) - {"tick_ms"}:
        np.testing.assert_array_equal(log[key], default[key])


def test_station_and_coordinator_accept_their_own_systems():
    replacements = Replacements({"weight_allocator": lambda default: Fixed()})
    coordinator = make_coordinator(SHORT, replacements)
    assert isinstance(coordinator.GetSubsystemByName("weight_allocator"), Fixed)
    station = make_station(SHORT, Replacements({"sampler": wrapped}))
    assert "its_inside" in systems_by_name(station)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (make_station, "weight_allocator"),
        (make_station, "wieght_allocator"),
        (make_coordinator, "sampler"),
        (make_closed_loop, "wieght_allocator"),
    ],
)
def test_other_names_are_refused(make, name):
    with pytest.raises(BadInput, match=f"^replacements: {name}: no such system that can") as error:
        make(SHORT, Replacements({name: wrapped}))
    valid = str(error.value).partition("valid: ")[2].rstrip(")").split(", ")
    inside = systems_by_name(make(SHORT)).keys() - {"station", "coordinator", "closed_loop"}
    assert set(valid) - {"station", "coordinator"} == inside


def test_a_controller_without_tick_times(default):
    """A LeafSystem with the ports of the MPC and constant outputs."""

    class Still(LeafSystem):
        def __init__(self, other):
            super().__init__()
            for i in range(other.num_input_ports()):
                port = other.get_input_port(i)
                if port.size():
                    self.DeclareVectorInputPort(port.get_name(), port.size())
                else:
                    self.DeclareAbstractInputPort(
                        port.get_name(), other.AllocateInputAbstract(port)
                    )
            for i in range(other.num_output_ports()):
                port = other.get_output_port(i)
                zeros = np.zeros(port.size())
                self.DeclareVectorOutputPort(
                    port.get_name(),
                    port.size(),
                    lambda context, output, zeros=zeros: output.SetFromVector(zeros),
                    {self.nothing_ticket()},
                )

    log = flown(SHORT, mpc=Still)
    assert log.exit_reason == "completed" and len(log["tick_ms"]) == 0
    np.testing.assert_array_equal(log["a_Bd_m_s2"], 0.0)
    np.testing.assert_allclose(
        log["p_B_m"], np.tile(default["p_B_m"][0], (len(log["p_B_m"]), 1)), atol=1e-3
    )


def wrapped(default):
    """Returns the default system inside a diagram with the same ports."""
    builder = DiagramBuilder()
    inner = builder.AddNamedSystem(f"{default.get_name() or 'its'}_inside", default)
    for i in range(inner.num_input_ports()):
        port = inner.get_input_port(i)
        builder.ExportInput(port, port.get_name())
    for i in range(inner.num_output_ports()):
        port = inner.get_output_port(i)
        builder.ExportOutput(port, port.get_name())
    return builder.Build()


@pytest.mark.parametrize(
    "name",
    [
        *("station", "coordinator", "sensors", "mpc", "physics", "plant", "multibody_plant"),
        *("rotors", "air", "rotor_faults", "residual_estimator"),
    ],
)
def test_a_diagram_around_the_default_system_flies_identically(name):
    faults = (RotorDegraded(start_s=0.1), LearnerPoisoned(start_s=0.1))
    scenario = replace(SHORT, faults=faults, residual=Residual(mode="online"), wind=BREEZE)
    log, default = flown(scenario, **{name: wrapped}), flown(scenario)
    for key in set(log.signals) - {"tick_ms"}:
        np.testing.assert_array_equal(log[key], default[key])


@pytest.mark.parametrize(
    ("by_name", "message"),
    [
        (
            {"mpc": lambda default: None},
            "replacements: mpc: expected a system, got NoneType",
        ),
        (
            {"mpc": Fixed()},
            "replacements: mpc: expected a function from a system to a system, got Fixed",
        ),
        (
            {"wieght_allocator": lambda default: Fixed()},
            "replacements: wieght_allocator: no such .*; did you mean 'weight_allocator'?",
        ),
        (
            {"weight_allocator": lambda default: Fixed(distances=3)},
            "weight_allocator: expected an input port 'distances' of size 2, got size 3",
        ),
        (
            {"weight_allocator": lambda default: Fixed(wind=3)},
            "weight_allocator: no signal for its input port 'wind'; valid: d_g, distances",
        ),
        (
            {"kinematics": lambda default: Fixed()},
            "kinematics: no signal for its input port 'd_g'; valid: reference, state",
        ),
    ],
)
def test_replacements_that_do_not_fit_are_refused(by_name, message):
    with pytest.raises(BadInput, match=message.replace("?", r"\?")):
        make_closed_loop(SHORT, Replacements(by_name))
