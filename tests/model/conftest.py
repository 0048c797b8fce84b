"""Ticks of a short flight in which constraints of the MPC are active."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.scenario import Clover, Mpc, Scenario
from aerodrake.station import make_closed_loop, make_context

FLOWN_S = 2.6


@pytest.fixture(scope="session")
def tight_scenario() -> Scenario:
    """A clover four times as fast as usual, with tight bounds of the base."""
    return Scenario(
        settle_s=0.0,
        reference=Clover(lap_s=6.0, start_s=0.5),
        mpc=Mpc(base_velocity_m_s=(0.3, 0.3, 0.3), base_acceleration_m_s2=(0.8, 0.8, 0.8)),
    )


@pytest.fixture(scope="session")
def ticks(tight_scenario) -> list[MpcInputs]:
    """Inputs of each tick of that flight."""
    diagram = make_closed_loop(tight_scenario)
    mpc = diagram.GetSubsystemByName("coordinator").GetSubsystemByName("mpc")
    simulator = Simulator(diagram, make_context(diagram, seed=0))
    context = mpc.GetMyContextFromRoot(simulator.get_context())
    period = tight_scenario.rates.mpc_period_s
    flown = []
    for time in np.arange(0, FLOWN_S, period):
        simulator.AdvanceTo(time)
        flown.append(mpc.tick_inputs(context))
    return flown


@pytest.fixture(scope="session")
def ticks_of(ticks, tight_scenario) -> Callable[[EquivalentModel], list[MpcInputs]]:
    """Returns a function that makes the ticks with x_0 in the layout of another model."""

    def ticks_of(model: EquivalentModel) -> list[MpcInputs]:
        flown = EquivalentModel.of(tight_scenario, model.joints)
        from_flown = np.empty(len(model.A), dtype=int)
        for name in model.axis_states:
            from_flown[model.base_state(name)] = flown.base_state(name)
        from_flown[model.joint_position] = flown.joint_position
        from_flown[model.joint_velocity] = flown.joint_velocity
        return [replace(tick, x_0=tick.x_0[from_flown]) for tick in ticks]

    return ticks_of
