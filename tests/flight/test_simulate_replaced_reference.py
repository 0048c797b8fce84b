"""Errors are relative to the reference that is flown, whoever provides it."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.reference.curves import HoverCurve
from aerodrake.model.reference.direction import make_direction
from aerodrake.scenario import FixedAxis, Scenario
from aerodrake.scenario.references import Clover, Hover
from aerodrake.systems.pointing import PointingSystem
from aerodrake.systems.reference import ReferenceSystem
from aerodrake.wiring.guidance import make_guidance
from aerodrake.wiring.replacements import Replacements

HOVER = Scenario(reference=Hover(), settle_s=6.0, duration=0.5)
STAGES_S = stage_times(HOVER.mpc, HOVER.rates.mpc_period_s)


def flown(scenario, **by_name):
    return FlightSimulation(scenario, Replacements(by_name)).fly()


def test_a_replaced_reference_is_the_one_that_errors_are_relative_to(vehicle):
    """A hover 0.2 m aside ends there: the error is micrometres, not 200 mm."""
    aside = vehicle.p_E + [0.2, 0.0, 0.0]
    moved = ReferenceSystem(HoverCurve(Hover(), aside), aside, HOVER.settle_s, STAGES_S)
    log = flown(HOVER, reference=lambda ours: moved)
    np.testing.assert_array_equal(log["p_Ed_m"], np.tile(aside, (len(log.time_s), 1)))
    np.testing.assert_allclose(log["p_E_m"][-1], aside, atol=1e-4)
    assert summarize(HOVER, log)["error"]["max_m"] < 1e-4


def test_a_replaced_guidance_is_the_one_that_errors_are_relative_to(vehicle):
    short = replace(HOVER, settle_s=0.1, duration=0.3)
    clover = replace(short, reference=Clover(start_s=0.2))
    log = flown(short, guidance=lambda ours: make_guidance(clover, vehicle))
    np.testing.assert_array_equal(log["p_Ed_m"], flown(clover)["p_Ed_m"])
    assert np.ptp(log["p_Ed_m"], axis=0).max() > 0.01


def test_a_guidance_may_lack_the_requested_reference(vehicle):
    """Errors are then of the followed reference."""
    short = replace(HOVER, settle_s=0.0, duration=0.1)

    def bare(ours):
        builder = DiagramBuilder()
        for name in ("reference", "horizon", "reference_verdict", "d_g"):
            if name == "reference":
                inner = builder.AddNamedSystem("inner", make_guidance(short, vehicle))
            builder.ExportOutput(inner.GetOutputPort(name), name)
        return builder.Build()

    log = flown(short, guidance=bare)
    np.testing.assert_array_equal(log["p_Ed_m"], log["followed_p_Ed_m"])
    assert log.is_followed.all() and log.error_m.max() < 1e-6


def test_a_replaced_direction_is_the_one_that_angles_are_relative_to(vehicle):
    scenario = replace(HOVER, orientation=FixedAxis())
    tilted = make_direction(FixedAxis(axis=(0.3, 0.0, -1.0)))
    pointing = PointingSystem(vehicle, tilted, HOVER.settle_s, STAGES_S)
    log = flown(scenario, pointing=lambda ours: pointing)
    assert log["tool_axis_d"][-1] == pytest.approx(np.array([0.3, 0.0, -1.0]) / np.hypot(0.3, 1.0))
    assert summarize(scenario, log)["orientation"]["max_rad"] < 1e-3
