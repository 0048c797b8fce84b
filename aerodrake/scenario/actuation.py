"""Actuation section of a scenario: flaws of rotors, joints and the setpoint link."""

from dataclasses import dataclass, replace
from typing import Self

from aerodrake.scenario.schema import Section, quantity


@dataclass(frozen=True)
class Actuation(Section):
    """Flaws of rotors, joints and the setpoint link, which no controller's model contains.

    Values of joints are one for all joints, or one for each.
    """

    # Dead time of the rotors, from a command until their thrusts begin to follow it.
    rotor_dead_time_s: float = quantity(0.0, "s", 0.0, 0.1)
    # Number of levels of a rotor's command from 0 to its largest thrust; 0 is continuous.
    rotor_levels: int = quantity(0, "1", 0, 1_000_000)
    # Standard deviation, from rotor to rotor, of a factor of 1 on the thrust; drawn from the seed.
    thrust_scatter: float = quantity(0.0, "1", 0.0, 0.2)
    # Fraction of the thrust that is lost at the end of the flight; the loss grows linearly.
    sag: float = quantity(0.0, "1", 0.0, 0.5)
    # Friction of the joints, beyond the damping in the URDF: of constant magnitude, and viscous.
    coulomb_n_m: tuple[float, ...] = quantity((0.0,), "N m", 0.0, 100.0)
    viscous_n_m_s_rad: tuple[float, ...] = quantity((0.0,), "N m s/rad", 0.0, 100.0)
    # Backlash and compliance between motor and link. The encoders are on the motor's side.
    backlash_rad: tuple[float, ...] = quantity((0.0,), "rad", 0.0, 0.1)
    flexibility_rad_n_m: tuple[float, ...] = quantity((0.0,), "rad/(N m)", 0.0, 0.1)
    # Latency of each message with setpoints, drawn uniformly from [low, high], and the probability
    # that it is lost. Setpoints start when they arrive.
    setpoint_latency_s: tuple[float, ...] = quantity((0.0, 0.0), "s", 0.0, 0.5, length=2)
    setpoint_loss: float = quantity(0.0, "1", 0.0, 1.0)

    @property
    def linear(self) -> Self:
        """Copy that can be linearised: without levels, Coulomb friction and backlash, and without
        sag, which varies with time. No message is lost, and each has the mean latency."""
        mean = sum(self.setpoint_latency_s) / 2
        return replace(
            self,
            rotor_levels=0,
            sag=0.0,
            coulomb_n_m=(0.0,),
            backlash_rad=(0.0,),
            setpoint_latency_s=(mean, mean),
            setpoint_loss=0.0,
        )
