"""Flaws that a scenario can have, and their keys."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

from aerodrake.scenario import Scenario

SILENT = Scenario()
"""A scenario without flaws."""


@dataclass(frozen=True)
class Flaw:
    """A flaw of sensors, actuators or environment.

    Attributes:
        name: Name in tables.
        keys: Dotted keys of the scenario; the flaw is silent if they have their defaults. A key of
            `filter` is the value that the filter assumes.
        is_random: True if the flaw differs from seed to seed.
    """

    name: str
    keys: tuple[str, ...]
    is_random: bool = False

    def is_present(self, scenario: Scenario) -> bool:
        """Returns True if a scenario has the flaw."""
        return any(_value(scenario, key) != _value(SILENT, key) for key in self.keys)


def _of(section: str, *names: str) -> tuple[str, ...]:
    return tuple(f"{section}.{name}" for name in names)


def _sampling(sensor: str, *others: str) -> tuple[str, ...]:
    return _of(f"sensors.{sensor}", *others, "latency_s", "loss", "stamp")


FLAWS = (
    Flaw("position noise", _of("sensors", "position_noise_m"), is_random=True),
    Flaw("velocity noise", _of("sensors", "velocity_noise_m_s"), is_random=True),
    Flaw("attitude noise", _of("sensors", "attitude_noise_rad"), is_random=True),
    Flaw("rate noise", _of("sensors", "rate_noise_rad_s"), is_random=True),
    Flaw("joint noise", _of("sensors", "joint_noise_rad"), is_random=True),
    Flaw("known delay", ("sensors.base_delay_s", "filter.delay_s")),
    Flaw("position sampling", _sampling("position", "period_s"), is_random=True),
    Flaw("attitude sampling", _sampling("attitude", "period_s"), is_random=True),
    Flaw("joint sampling", _sampling("joints", "period_s"), is_random=True),
    Flaw("position bias", _of("sensors.position", "bias_m")),
    Flaw("attitude bias", _of("sensors.attitude", "bias_rad")),
    Flaw(
        "gyroscope", _of("sensors.attitude", "rate_bias_rad_s", "rate_drift_rad_s2"), is_random=True
    ),
    Flaw("joint zeros", _of("sensors.joints", "zero_rad")),
    Flaw("encoders", _of("sensors.joints", "resolution_bits", "rate", "rate_filter_s")),
    Flaw(
        "accelerometer",
        _sampling("accelerometer", "noise_m_s2", "bias_m_s2", "drift_m_s3"),
        is_random=True,
    ),
    Flaw(
        "tool sensor",
        _sampling("tool", "noise_m", "delay_s", "mounting_m", "visible_rad"),
        is_random=True,
    ),
    Flaw("rotor dead time", _of("actuation", "rotor_dead_time_s")),
    Flaw("rotor levels", _of("actuation", "rotor_levels")),
    Flaw("rotor lag", _of("mismatch", "rotor_lag_scale")),
    Flaw("thrust scatter", _of("actuation", "thrust_scatter"), is_random=True),
    Flaw("battery sag", _of("actuation", "sag")),
    Flaw("loop gain", _of("mismatch", "thrust_scale", "torque_scale")),
    Flaw("joint friction", _of("actuation", "coulomb_n_m", "viscous_n_m_s_rad")),
    Flaw("backlash", _of("actuation", "backlash_rad")),
    Flaw("flexibility", _of("actuation", "flexibility_rad_n_m")),
    Flaw("setpoint link", _of("actuation", "setpoint_latency_s", "setpoint_loss"), is_random=True),
    Flaw("wind", _of("wind", "velocity_m_s", "shear_exponent", "wave_m_s", "wave_rad_m")),
    Flaw("gusts", _of("wind", "gust_m_s"), is_random=True),
    Flaw("rotor drag", _of("air", "rotor_drag_n_s_m")),
    Flaw("inflow", _of("air", "inflow_s_m")),
    Flaw("ground effect", _of("air", "rotor_radius_m", "ceiling_m")),
    Flaw("payload", _of("payload", "mass_kg")),
    Flaw("mass and inertia", _of("mismatch", "mass_scale", "inertia_scale")),
    Flaw("centre of mass", _of("mismatch", "centre_of_mass_m")),
)
"""All flaws, in the order of tables."""


def present_flaws(scenario: Scenario) -> tuple[Flaw, ...]:
    """Returns the flaws that a scenario has, in the order of `FLAWS`."""
    return tuple(flaw for flaw in FLAWS if flaw.is_present(scenario))


def silence(flaws: Iterable[Flaw]) -> Mapping[str, Any]:
    """Returns the values, by dotted key, with which flaws are silent."""
    return {key: _value(SILENT, key) for flaw in flaws for key in flaw.keys}


def _value(scenario: Scenario, key: str) -> Any:
    return reduce(getattr, key.split("."), scenario)
