"""Identification of K_B, the gain of the base with its flight controller in the equivalent model.

The station flies open loop, along each axis once with the arm still and once with the arm
moving. The setpoint is p_d alone with v_d = a_d = 0, so that the models of both flight
interfaces, p' = K (p_d - p) and p' = v_d + K (p_d - p), reduce to

    v = K (p_d - p) + constant,

which is fitted to the samples that the MPC receives. (With v_d the derivative of p_d the error
p_d - p would be too small to fit K.)

p_d is a chirp over the band in which the MPC moves it. Its speed has the same amplitude at all
frequencies. The error p_d - p nearly has as well, so that all octaves have equal influence.
Alternatives, with the gains of `clover_paper` and of `clover`: steps of 0.1 to 0.2 m excite
frequencies far above the band, at which the base is of second order (R^2 0.7, K 1.6 and 1.2);
a chirp with constant amplitude of position is dominated by the highest frequencies (R^2 0.96
and 0.86). This chirp has R^2 0.98 and 0.95. In flights of `clover_paper` and
`moving_target_paper` its K predicts the base over the MPC's horizon with an RMS error within
3 % of the error of the best K for that flight; K from steps has up to 6 times that error. With
the trajectory interface these errors hardly depend on K.
"""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydrake.trajectories import PiecewisePolynomial
from scipy.integrate import cumulative_trapezoid
from scipy.signal import chirp

from aerodrake.flight.excitation import excite
from aerodrake.model.equivalent.identification import GainFit, fit_gain
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.errors import BadInput, ProcessDied, ScenarioError, sourced
from aerodrake.support.limits import SEED
from aerodrake.support.processes import run_parallel

AXES = ("x", "y", "z")
ARMS = ("still", "moving")

FLIGHTS = len(AXES) * len(ARMS)
DURATION_S = 60.0
"""Duration of each flight."""
BAND_HZ = (0.04, 0.5)
SPEED_M_S = 0.15
"""Amplitude of the chirp's speed. The base stays within 1 m of its initial position."""
ARM_BAND_HZ = (0.1, 0.4)
"""Frequencies of the first and of the last joint."""
ARM_SWING_RAD = 0.15
"""Swing of each joint, which keeps the end-effector in the learning space."""
BLOCK_S = 5.0
LEAST_R2 = 0.5
"""Smallest R^2 of a response that is accepted as first order."""


class Manoeuvre(NamedTuple):
    """One flight: the axis along which the base is excited, and the motion of the arm."""

    scenario: Scenario
    axis: int
    arm: str


@dataclass(frozen=True)
class Record:
    """Samples of one axis of one flight at the MPC's ticks.

    Attributes:
        time_s: (T,) s, reference time.
        p_d: (T,) m, setpoint of the base.
        p: (T,) m, measured position.
        v: (T,) m/s, measured velocity.
    """

    time_s: np.ndarray
    p_d: np.ndarray
    p: np.ndarray
    v: np.ndarray


@dataclass(frozen=True)
class AxisIdentification:
    """K_B of one axis.

    Attributes:
        fit: Fit to all flights of the axis.
        records: Samples of each flight, by the motion of the arm (`ARMS`).
        gains: 1/s, fit to each flight alone, by the motion of the arm.
    """

    fit: GainFit
    records: dict[str, Record]
    gains: dict[str, float]


@dataclass(frozen=True)
class Identification:
    """Identified K_B of all axes.

    Attributes:
        scenario: The given scenario, with its own K_B.
        axes: Identification of each axis, by name.
    """

    scenario: Scenario
    axes: dict[str, AxisIdentification]

    @property
    def k_b(self) -> tuple[float, ...]:
        """(3,) 1/s, the diagonal of K_B, rounded to three digits."""
        return tuple(float(f"{axis.fit.gain:.3g}") for axis in self.axes.values())

    @property
    def identified_scenario(self) -> Scenario:
        """The scenario with the identified K_B."""
        model = dataclasses.replace(self.scenario.model, k_b=self.k_b)
        return dataclasses.replace(self.scenario, model=model)


def identify_gains(
    scenario: Scenario, jobs: int, progress: Callable[[float], None] = lambda flown_s: None
) -> Identification:
    """Flies all axes with both motions of the arm, each in its own process, and fits K_B.

    Args:
        scenario: Scenario whose reference is ignored.
        jobs: Number of concurrent processes.
        progress: Called with the simulated time in s of each finished flight.

    Raises:
        ScenarioError: if the response of the base to its setpoint is not of first order.
        ProcessDied: if the process of a flight died.
    """
    VehicleModel.load(scenario)  # Raises errors of the robot's file before the flights.
    manoeuvres = [Manoeuvre(scenario, axis, arm) for axis in range(3) for arm in ARMS]
    records: dict[tuple[int, str], Record] = {}
    for index, result in run_parallel(fly, manoeuvres, jobs):
        _, axis, arm = manoeuvres[index]
        name = f"{AXES[axis]}, arm {arm}"
        if isinstance(result, BadInput):
            raise result
        if isinstance(result, ProcessDied):
            raise ProcessDied(f"{name}: {result}")
        if isinstance(result, Exception):
            raise RuntimeError(f"{name}: its process failed") from result
        records[axis, arm] = result
        progress(DURATION_S)
    axes = {
        name: identify_axis(scenario, {arm: records[axis, arm] for arm in ARMS})
        for axis, name in enumerate(AXES)
    }
    for name, axis in axes.items():
        if not axis.fit.r2 >= LEAST_R2:
            raise _not_first_order(scenario, f"the fit of {name} has R^2 {axis.fit.r2:.2f}")
    identification = Identification(scenario, axes)
    with sourced(scenario.source):
        dataclasses.replace(scenario.model, k_b=identification.k_b)  # Checks the range of K_B.
    return identification


def identify_axis(scenario: Scenario, records: dict[str, Record]) -> AxisIdentification:
    """Fits K_B of one axis to all its flights, and to each of them alone."""
    block = round(BLOCK_S / scenario.rates.mpc_period_s)

    def fit(flights: list[Record]) -> GainFit:
        return fit_gain([f.p_d - f.p for f in flights], [f.v for f in flights], block)

    gains = {arm: fit([record]).gain for arm, record in records.items()}
    return AxisIdentification(fit([*records.values()]), records, gains)


def fly(manoeuvre: Manoeuvre) -> Record:
    """Flies one manoeuvre. The seed of its noise depends on the scenario's seed and the manoeuvre.

    Raises:
        ScenarioError: if the vehicle crashes.
    """
    scenario, axis, arm = manoeuvre
    seeds = np.random.SeedSequence([scenario.seed, axis, ARMS.index(arm)])
    seeded = dataclasses.replace(scenario, seed=int(seeds.generate_state(1)[0]) % (SEED[1] + 1))
    vehicle = VehicleModel.load(scenario)
    base, joints = base_motion(scenario, vehicle, axis), arm_motion(scenario, vehicle, arm)
    try:
        flown = excite(seeded, base, joints)
    except RuntimeError as error:  # The plant's step failed.
        problem = f"along {AXES[axis]}, arm {arm}, it crashes: {error}".splitlines()[0]
        raise _not_first_order(scenario, problem) from None
    states = split_state(flown.state.T)
    return Record(flown.time_s, flown.base_setpoint[:, axis], states.p_B[axis], states.v_B[axis])


def base_motion(scenario: Scenario, vehicle: VehicleModel, axis: int) -> PiecewisePolynomial:
    """Returns (3,) m, the chirp along one axis, constant between the flight controller's ticks.

    Its derivatives are therefore zero. It steps just before each tick, so that the controller
    and the recorded samples have the same value.
    """
    period = scenario.rates.flight_period_s
    ticks = period * np.arange(round(DURATION_S / period) + 1)
    start, end = BAND_HZ
    velocity = SPEED_M_S * chirp(ticks, start, DURATION_S, end, method="logarithmic", phi=-90)
    position = np.tile(vehicle.p_B, (len(ticks), 1))
    position[:, axis] += cumulative_trapezoid(velocity, dx=period, initial=0)
    return PiecewisePolynomial.ZeroOrderHold(ticks - scenario.rates.plant_step_s / 4, position.T)


def arm_motion(scenario: Scenario, vehicle: VehicleModel, arm: str) -> PiecewisePolynomial:
    """Returns (n,) rad, all joints at rest, or each swinging away from its nearer limit."""
    period = scenario.rates.mpc_period_s
    ticks = period * np.arange(round(DURATION_S / period) + 1)
    velocity = np.zeros((len(ticks), vehicle.joints))
    if arm == "moving":
        above, below = vehicle.upper - vehicle.working, vehicle.working - vehicle.lower
        swing = np.minimum(ARM_SWING_RAD, np.maximum(above, below))
        amplitude = np.where(above > below, 1, -1) * swing
        omega = 2 * np.pi * np.geomspace(*ARM_BAND_HZ, vehicle.joints)
        velocity = amplitude / 2 * omega * np.sin(np.outer(ticks, omega))
    return held_acceleration_motion(vehicle.working, velocity, period)


def _not_first_order(scenario: Scenario, problem: str) -> ScenarioError:
    expected = f"expected a base with the response p' = K_B (p_d - p), with R^2 of {LEAST_R2:g}"
    return ScenarioError(scenario.source, "flight", f"{expected} or more; {problem}")
