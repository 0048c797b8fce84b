"""Flight controller: the base's low-level controller."""

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.low_level.flight_state import FlightOutputs, FlightState
from aerodrake.model.low_level.inner_loop import InnerLoop, inner_loop
from aerodrake.model.low_level.outer_loop import OuterLoop, outer_loop
from aerodrake.model.low_level.thrust_allocation import allocate
from aerodrake.model.vehicle.state import BASE_VELOCITIES, VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.model.vehicle.whole_body import WholeBody, commanded_motion, rigid_body_effort
from aerodrake.scenario import Flight, Rotor
from aerodrake.support.arguments import Duration, Period, checked
from aerodrake.systems.named_state import NamedState

FEEDFORWARD_FILTER_S = 0.05
"""Time constant of the low-pass filter of q_d'' in the feedforward `torque`.

Without the filter, vehicles with arms as heavy as the base are unstable with delay.
"""

ROTATION_FACTOR = 0.5
"""Factor on the tangential acceleration in the modelled acceleration of the base's origin.

Thrust accelerates the common centre of mass of base and arm. If the base also rotates, its origin
has the additional acceleration alpha x r, since it is at the distance r from that centre. The MPC's
equivalent model does not contain this term. The factor is a compromise between two effects. With 1,
vehicles with heavy arms that hang low have a third of the damping that they have with 0.5. With 0,
the term is estimated as a disturbance, and noise causes larger errors.
"""


class FlightController(LeafSystem):
    """ESO-based position and attitude control of the base.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `base_setpoint` (9): p_d, v_d, a_d in m, m/s, m/s^2. The `position` interface
            uses p_d alone.
        in `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2. Used by the
            feedforward alone.
        out `thrust_command` (k): N, per rotor.
        out `acceleration` (6): modelled acceleration of the base from this command until
            the next, without disturbances: of its origin, m/s^2 in the world, and
            angular, rad/s^2 in the base frame. With feedforward it includes the arm's reaction.
        out `specific_thrust` (1): m/s^2, collective thrust over mass at the next sample, modelled
            by rotors whose lag is the mean of rise and fall.
        out `reaction` (3): m/s^2, by which the arm's motion reduces the base's acceleration, and
            which thrust compensates; zero unless `feedforward` is whole_body.
        out `disturbance` (6): estimated acceleration by other forces than thrust and gravity,
            m/s^2 in the world: h of the position ESO, less `reaction`. And h of the
            attitude ESO, rad/s^2 in the base frame.
        out `saturated` (1): 1 if the limit of tilt or those of the rotors (thrust, or torque
            about any axis) prevent the wrench that the control laws demand, else 0.

        At the instant of a sample, these outputs are still those of the previous sample,
        since the update for this sample follows after `offset`.
    State:
        a group for each field of `FlightState`: position observer (9), attitude
        observer (6), integral of the position error (3), desired attitude (9), its
        filtered rate (3), modelled rotor thrust (k), specific thrust (1), acceleration (6),
        filtered q_d'' (n) and measured position (3).
        And a group for each other output. The observers start at the first sample, and move with
        a position that jumps.
    Rate:
        `period`, after `offset`, so that it uses the MPC's command of the same instant.

    The observers receive the saturated thrust, which prevents windup. The attitude
    observer receives the modelled thrust of lagging rotors. The slower position observer
    receives the commanded thrust: if commands oscillate, rotors that rise faster than they fall
    give more on average, which it estimates as a disturbance. `specific_thrust` therefore has the
    mean of the command; otherwise the surplus would count twice in its sum with the disturbance.

    With `feedforward` torque, inverse dynamics give the torque of the arm's commanded motion, with
    its accelerations filtered by `FEEDFORWARD_FILTER_S`. Thrust does not compensate the force of
    this motion, but the modelled acceleration of the base includes it. Estimated as a disturbance,
    it would be late, and the MPC would predict that it lasts and move the arm against it: with arms
    nearly as heavy as the base, that loop is unstable. With whole_body the accelerations are not
    filtered, and give the force as well, which tilts the base. Without feedforward the controller's
    model is a rigid body with its mass at the origin, and the observers estimate the rest.

    Attributes:
        trim_acceleration: (6,) `acceleration` in trim. Without feedforward it is not
            zero: the attitude observer's h cancels it.

    Args:
        config: Gains and interface.
        rotor: Limits and lag of a rotor.
        vehicle: Inertia and trim.
        period: s.
        offset: s, time of the first update.
    """

    @checked
    def __init__(
        self, config: Flight, rotor: Rotor, vehicle: VehicleModel, period: Period, offset: Duration
    ):
        super().__init__()
        self._outer = OuterLoop.make(config, rotor, vehicle, period)
        self._inner = InnerLoop.make(config, rotor, vehicle, period)
        self._feedforward = config.feedforward
        self._smoothing = period / (period + FEEDFORWARD_FILTER_S)
        has_feedforward = config.feedforward != "none"
        self._whole_body = WholeBody(vehicle.plant) if has_feedforward else None

        trim = allocate(self._inner.rotors, vehicle.trim_wrench)
        modelled = vehicle.trim_wrench[1:] * has_feedforward
        trim_h = self._inner.inverse_inertia @ (modelled - vehicle.trim_wrench[1:])
        at_rest = FlightState.at_rest(vehicle.p_B, trim_h, trim, vehicle.mass, vehicle.joints)
        self.trim_acceleration = at_rest.acceleration

        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        self._setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * vehicle.joints)
        self._loops = NamedState(self, at_rest)
        self._outputs = NamedState(
            self,
            FlightOutputs(
                thrust_command=trim,
                reaction=np.zeros(3),
                disturbance=np.concatenate([np.zeros(3), trim_h]),
                saturated=False,
            ),
        )
        for name in ("acceleration", "specific_thrust"):
            self.DeclareStateOutputPort(name, self._loops.groups[name])
        for name, group in self._outputs.groups.items():
            self.DeclareStateOutputPort(name, group)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        state = self._state.Eval(context)
        last = self._loops.read(context).aligned(split_state(state), self._inner.lag.dt)
        if self._feedforward == "torque":
            qddot_d = np.split(self._joint_setpoint.Eval(context), 3)[2]
            filtered = last.joint_acceleration + self._smoothing * (
                qddot_d - last.joint_acceleration
            )
            last = last._replace(joint_acceleration=filtered)
        position = outer_loop(self._outer, last, state, self._setpoint.Eval(context))
        effort = self._effort(context, last, state, position.a_B)
        loops, outputs = inner_loop(self._inner, last, state, position, effort)
        if self._feedforward == "torque":
            loops = loops._replace(acceleration=self._with_arm(context, state, loops))
        self._loops.write(discrete, loops)
        self._outputs.write(discrete, outputs)

    def _effort(
        self, context: Context, last: FlightState, state: np.ndarray, a_B: np.ndarray
    ) -> np.ndarray:
        """Returns the effort (6,) or more that gives the base a_B and no angular acceleration."""
        rigid_body = rigid_body_effort(self._inner.mass, self._inner.inertia, state, a_B)
        if self._whole_body is None:
            return rigid_body
        x, vdot = commanded_motion(state, self._joint_setpoint.Eval(context), a_B)
        if self._feedforward == "whole_body":
            return self._whole_body.effort(x, vdot)
        vdot[BASE_VELOCITIES:] = last.joint_acceleration
        return np.concatenate((self._whole_body.effort(x, vdot)[:3], rigid_body[3:6]))

    def _with_arm(self, context: Context, state: np.ndarray, loops: FlightState) -> np.ndarray:
        """Returns the modelled acceleration (6,) of the base, with the arm's motion.

        `loops.acceleration` is that of the common centre of mass, by thrust and gravity. The
        acceleration of the base's origin is less by r_C'', where r_C is the centre's position
        relative to the origin. It changes by the commanded motion of the arm, and by the rotation
        of the base, to which `ROTATION_FACTOR` applies.
        """
        x, vdot = commanded_motion(state, self._joint_setpoint.Eval(context), np.zeros(3))
        acceleration = loops.acceleration.copy()
        angular = acceleration[3:] + loops.attitude_observer[-1]
        vdot[:3] = ROTATION_FACTOR * (split_state(state).R_B @ angular)
        acceleration[:3] -= self._whole_body.centre_acceleration(x, vdot)
        return acceleration
