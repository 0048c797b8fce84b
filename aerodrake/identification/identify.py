"""Identification of the equivalent model: K_B of a scenario's base under its flight controller.

The station is flown open loop, each axis in turn, once with the arm still and
once with it moving. The setpoint is p_d alone, v_d and a_d being zero: of either
flight interface's model, p' = K (p_d - p) or p' = v_d + K (p_d - p), this leaves

    v = K (p_d - p) + constant,

which is fitted to the samples that the MPC sees. (A v_d that is the derivative
of p_d leaves next to no error to fit K to.)

p_d is a chirp over the band in which the MPC moves it. Its speed has the same
amplitude at every frequency, hence the error p_d - p nearly has, and every
octave counts the same. Tried beside it, with the gains of `clover_paper` and of
`clover`: steps of 0.1 to 0.2 m excite what lies far above that band, where the
base is of second order (R^2 0.7, K 1.6 and 1.2); of a chirp whose position has
the same amplitude all over, nearly all is upper end (R^2 0.96 and 0.86). This
one has R^2 0.98 and 0.95. In flights of `clover_paper` and `moving_target_paper`
its K predicts the base over the MPC's horizon with an RMS error within 3 % of
that of the best K in hindsight, where the steps' K has up to 6 times as much;
with the trajectory interface these errors hardly depend on K.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.trajectories import PiecewisePolynomial
from scipy.integrate import cumulative_trapezoid
from scipy.signal import chirp

from aerodrake.flight.excitation import excite
from aerodrake.model.equivalent.identification import GainFit, fit_gain
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Model, Scenario
from aerodrake.scenario.schema import as_mapping, build
from aerodrake.support.errors import BadInput, ProcessDied, ScenarioError
from aerodrake.support.processes import run_parallel

AXES = ("x", "y", "z")
ARMS = ("still", "moving")

FLIGHTS = len(AXES) * len(ARMS)
DURATION_S = 60.0
"""Of each flight."""
BAND_HZ = (0.04, 0.5)
SPEED_M_S = 0.15
"""Amplitude of the chirp's speed. The base stays above where it starts, within 1 m."""
ARM_BAND_HZ = (0.1, 0.4)
"""From the first joint's frequency to the last one's."""
ARM_SWING_RAD = 0.15
"""How far each joint swings; together they stay in the learning space."""
BLOCK_S = 5.0
LEAST_R2 = 0.5
"""Of a base that can be said to answer as one of first order."""


@dataclass(frozen=True)
class Manoeuvre:
    """One flight: along which axis the base is excited, and what the arm does."""

    scenario: Scenario
    axis: int
    arm: str


@dataclass(frozen=True)
class Record:
    """One axis of one flight at the MPC's ticks.

    Attributes:
        time_s: (T,) s, reference time.
        p_d: (T,) m, where the base is commanded to be.
        p: (T,) m, where it is measured.
        v: (T,) m/s, how fast.
    """

    time_s: np.ndarray
    p_d: np.ndarray
    p: np.ndarray
    v: np.ndarray


@dataclass(frozen=True)
class AxisIdentification:
    """K_B of one axis.

    Attributes:
        fit: To all its flights.
        records: Its flights, by what the arm does.
        gains: 1/s, fitted to each flight by itself.
    """

    fit: GainFit
    records: dict[str, Record]
    gains: dict[str, float]


@dataclass(frozen=True)
class Identification:
    """What was identified.

    Attributes:
        scenario: As it was, with the K_B it had.
        axes: By name.
    """

    scenario: Scenario
    axes: dict[str, AxisIdentification]

    @property
    def k_b(self) -> tuple[float, ...]:
        """(3,) 1/s, the diagonal of K_B to three digits, as scenarios hold it."""
        return tuple(float(f"{axis.fit.gain:.3g}") for axis in self.axes.values())

    @property
    def identified_scenario(self) -> Scenario:
        """The scenario with this K_B."""
        model = dataclasses.replace(self.scenario.model, k_b=self.k_b)
        return dataclasses.replace(self.scenario, model=model)


def identify(
    scenario: Scenario, jobs: int, progress: Callable[[float], None] = lambda flown_s: None
) -> Identification:
    """Flies all axes with both arms, in processes of their own, and fits K_B.

    Args:
        scenario: Its vehicle, station, rates and seed; its reference is not flown.
        jobs: How many processes at a time.
        progress: Called with the simulated time in s of each flight that is done.

    Raises:
        ScenarioError: if the base does not answer its setpoint as the model has it.
        ProcessDied: if the process of a flight did.
    """
    VehicleModel.load(scenario)  # A bad robot is better refused here than six times there.
    manoeuvres = [Manoeuvre(scenario, axis, arm) for axis in range(3) for arm in ARMS]
    records: dict[tuple[int, str], Record] = {}
    for index, result in run_parallel(fly, manoeuvres, jobs):
        manoeuvre = manoeuvres[index]
        name = f"{AXES[manoeuvre.axis]}, arm {manoeuvre.arm}"
        if isinstance(result, BadInput):
            raise result
        if isinstance(result, ProcessDied):
            raise ProcessDied(f"{name}: {result}")
        if isinstance(result, Exception):
            raise RuntimeError(f"{name}: its process failed") from result
        records[manoeuvre.axis, manoeuvre.arm] = result
        progress(DURATION_S)
    axes = {
        name: identify_axis(scenario, {arm: records[axis, arm] for arm in ARMS})
        for axis, name in enumerate(AXES)
    }
    for name, axis in axes.items():
        if not axis.fit.r2 >= LEAST_R2:
            raise _not_first_order(scenario, f"the fit of {name} has R^2 {axis.fit.r2:.2f}")
    identification = Identification(scenario, axes)
    build(Model, as_mapping(identification.identified_scenario.model), scenario.source, "model")
    return identification


def identify_axis(scenario: Scenario, records: dict[str, Record]) -> AxisIdentification:
    """Fits K_B of one axis to its flights, together and one by one."""
    block = round(BLOCK_S / scenario.rates.mpc_period_s)

    def fit(flights: list[Record]) -> GainFit:
        return fit_gain([f.p_d - f.p for f in flights], [f.v for f in flights], block)

    gains = {arm: fit([record]).gain for arm, record in records.items()}
    return AxisIdentification(fit([*records.values()]), records, gains)


def fly(manoeuvre: Manoeuvre) -> Record:
    """Flies one manoeuvre. Noise is that of the scenario's seed, different in each.

    Raises:
        ScenarioError: if the vehicle crashes.
    """
    scenario, axis, arm = manoeuvre.scenario, manoeuvre.axis, manoeuvre.arm
    seeds = np.random.SeedSequence([scenario.seed, axis, ARMS.index(arm)])
    seeded = dataclasses.replace(scenario, seed=int(seeds.generate_state(1)[0]) % 2**31)
    vehicle = VehicleModel.load(scenario)
    base, joints = base_motion(scenario, vehicle, axis), arm_motion(scenario, vehicle, arm)
    try:
        flown = excite(seeded, base, joints)
    except RuntimeError as error:  # The plant cannot step.
        problem = f"along {AXES[axis]}, arm {arm}, it crashes: {error}".splitlines()[0]
        raise _not_first_order(scenario, problem) from None
    states = split_state(flown.state.T)
    return Record(flown.time_s, flown.base_setpoint[:, axis], states.p_B[axis], states.v_B[axis])


def base_motion(scenario: Scenario, vehicle: VehicleModel, axis: int) -> PiecewisePolynomial:
    """(3,) m, the chirp along one axis, held from one tick of the flight controller to the next.

    Held, its derivatives are zero; it steps just before the tick, so that the
    controller and whoever samples it see the same.
    """
    period = scenario.rates.flight_period_s
    ticks = period * np.arange(round(DURATION_S / period) + 1)
    start, end = BAND_HZ
    velocity = SPEED_M_S * chirp(ticks, start, DURATION_S, end, method="logarithmic", phi=-90)
    position = np.tile(vehicle.p_B, (len(ticks), 1))
    position[:, axis] += cumulative_trapezoid(velocity, dx=period, initial=0)
    return PiecewisePolynomial.ZeroOrderHold(ticks - scenario.rates.plant_step_s / 4, position.T)


def arm_motion(scenario: Scenario, vehicle: VehicleModel, arm: str) -> PiecewisePolynomial:
    """(n,) rad, every joint at rest, or swinging at its own frequency to where it has room."""
    period = scenario.rates.mpc_period_s
    ticks = period * np.arange(round(DURATION_S / period) + 1)
    velocity = np.zeros((len(ticks), vehicle.joints))
    if arm == "moving":
        above, below = vehicle.upper - vehicle.working, vehicle.working - vehicle.lower
        amplitude = np.where(above > below, 1, -1) * np.minimum(
            ARM_SWING_RAD, np.maximum(above, below)
        )
        omega = 2 * np.pi * np.geomspace(*ARM_BAND_HZ, vehicle.joints)
        velocity = amplitude / 2 * omega * np.sin(np.outer(ticks, omega))
    return held_acceleration_motion(vehicle.working, velocity, period)


def _not_first_order(scenario: Scenario, problem: str) -> ScenarioError:
    return ScenarioError(
        scenario.source,
        "flight",
        f"expected a base that answers as p' = K_B (p_d - p), with R^2 of {LEAST_R2:g} "
        f"or more; {problem}",
    )
