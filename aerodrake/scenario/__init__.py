"""One flight as data: the sections of a scenario, their units and ranges, and its YAML file."""

from aerodrake.scenario.sections import (
    Allocation,
    Arm,
    Baseline,
    Clik,
    Filter,
    Flight,
    Model,
    Mpc,
    Rates,
    Residual,
    Rotor,
    Scenario,
    Supervisor,
    Vehicle,
    Weights,
)

__all__ = [
    "Allocation",
    "Arm",
    "Baseline",
    "Clik",
    "Filter",
    "Flight",
    "Model",
    "Mpc",
    "Rates",
    "Residual",
    "Rotor",
    "Scenario",
    "Supervisor",
    "Vehicle",
    "Weights",
]
