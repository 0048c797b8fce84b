"""Section of the residual: the network, online learning of its last layer, and its guards."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from aerodrake.scenario.schema import Section, choice, file, quantity


class Guards(NamedTuple):
    """Guards of online learning and of the gate; by default none is active.

    Each is the value of the key of its name in `Residual`, where it is described.
    """

    max_step: float = 0.0
    max_drift: float = 0.0
    max_error_m_s: float = 0.0
    freeze_saturated: bool = False
    gate_s: float = 0.0
    max_offset_m_s: float = 0.0


@dataclass(frozen=True)
class Residual(Section):
    """Residual Delta of the equivalent model: the network and online learning of its last layer.

    Velocities are c Delta, what Delta adds to the predicted velocity in one period.
    """

    # off: Delta is zero. offline: the network is constant. online: its last layer is updated.
    mode: str = choice("off", "offline", "online")
    # A trained network. Empty: an untrained one, whose output is zero until it learns online.
    checkpoint: str = file()
    # Step size of the stochastic gradient descent, and B_l, its number of samples.
    learning_rate: float = quantity(0.0015, "1", 0.0, 1.0)
    batch: int = quantity(20, "samples", 1, 1000)
    # The paper's eq. 6 as printed: without the bounds and the gate of the keys below.
    as_printed: bool = False
    # Bounds of online learning: of one step of the last layer, of its distance from the offline
    # layer, and of the label's error; 0 is no bound. clover_paper reaches 0.00006, 0.0014 and
    # 0.017 m/s. moving_target_paper, whose learning rate exceeds the bound of a stable step,
    # reaches 0.012 m/s and 0.19 m/s, and steps of 0.08 m/s that are shortened; without bounds its
    # last layer diverges.
    max_step: float = quantity(0.01, "m/s", 0.0, 100.0)
    max_drift: float = quantity(0.3, "m/s", 0.0, 100.0)
    max_error_m_s: float = quantity(0.5, "m/s", 0.0, 100.0)
    # Stop learning while the flight controller is saturated; the paper does not.
    freeze_saturated: bool = True
    # Averaging time of the gate, which passes Delta only while it improves the prediction; 0 always
    # passes it.
    gate_s: float = quantity(1.0, "s", 0.0, 60.0)
    # Largest mean offset between measured velocity and the derivative of measured position; above
    # it samples are rejected as inconsistent; 0 is no bound.
    max_offset_m_s: float = quantity(0.005, "m/s", 0.0, 100.0)

    @cached_property
    def guards(self) -> Guards:
        """Guards of online learning and gate: the keys of their names, or none if `as_printed`."""
        return Guards() if self.as_printed else Guards(*(getattr(self, k) for k in Guards._fields))
