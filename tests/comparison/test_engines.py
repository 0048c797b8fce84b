"""One flight in both engines: its variants, and differences with closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.comparison.engines import (
    are_engines,
    difference_table,
    engine_differences,
    engine_variants,
)
from aerodrake.comparison.table import comparison_table
from aerodrake.scenario import Physics


def test_each_engine_flies_the_scenario_unchanged(scenario):
    rk4 = replace(scenario, physics=Physics(engine="mujoco", integrator="rk4", substeps=2))
    for given in (scenario, rk4):
        variants = engine_variants(given)
        assert are_engines(variants) and not are_engines(["drake"])
        assert variants["drake"] == scenario
        assert variants["mujoco"].physics.integrator == given.physics.integrator
        assert replace(variants["mujoco"], physics=given.physics) == given


class Flown(dict):
    """A log of three samples, later ones twice as far from the first."""

    time_s = np.arange(3.0)

    def __init__(self, scale: float):
        half = scale * 0.05 * np.arange(3.0)
        super().__init__(
            p_E_m=scale * np.outer(np.arange(3), [3e-3, 4e-3, 0]),
            p_B_m=np.zeros((3, 3)),
            quaternion=np.column_stack([np.cos(half), np.sin(half), 0 * half, 0 * half]),
            q_rad=scale * np.outer(np.arange(3), [0.01, -0.02]),
            thrust_n=scale * np.ones((3, 4)),
        )


def test_differences_are_those_at_the_same_times():
    theirs = Flown(1.0)
    theirs["quaternion"] *= -1  # The same attitude.
    differences = engine_differences({"drake": Flown(0.0), "mujoco": theirs})
    expected = {
        "tool_m": (0.005, 0.01),
        "base_m": (0, 0),
        "attitude_rad": (0.1, 0.2),
        "joints_rad": (0.02, 0.04),
        "thrust_n": (1, 1),
    }
    for name, (mean, most) in expected.items():
        assert differences[name]["mean"] == pytest.approx(mean, abs=1e-12)
        assert differences[name]["max"] == pytest.approx(most, abs=1e-12)
    assert difference_table(differences).splitlines()[1].split() == [
        *("tool's", "position", "5", "10", "mm")
    ]
    assert engine_differences({"drake": theirs}) == {} and difference_table({}) == ""


def test_a_failed_flight_is_shown():
    failed = {"exit_reason": "failed", "exit_cause": "why"}
    table = comparison_table({"drake": failed, "mujoco": failed}, "hover")
    assert table.count("failed: why") == 2
