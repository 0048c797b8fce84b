"""The reference as a system."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.model.reference.reference_curve import ReferenceCurve, hover_then_follow
from aerodrake.support.arguments import Duration, Vector, Vector3, checked


class ReferenceSystem(LeafSystem):
    """Desired motion of the end-effector, now and over the MPC's horizon.

    Reference time is the context's time minus `settle_s`, rounded to 1 ns. Before 0 the
    reference rests at the start, and so does its horizon. All vectors are in the world frame.

    Ports:
        out `reference` (6): p_E,d, p_E,d' in m and m/s, now. Errors of the flight are relative
            to it; the MPC receives the horizon.
        out `horizon` (6 (N + 1)): p_E,d, p_E,d' in m and m/s, now and at each stage of the
            horizon; row-major (N + 1, 6).
        out `d_g` (1): m, diameter of the target trajectory; infinite for a moving target.
    State, rate:
        none; a function of time.

    Args:
        curve: Motion over reference time.
        start: (3,) m, initial position of the end-effector.
        settle_s: s, hover before reference time 0.
        stages_s: (N + 1,) s, from now to each stage, 0 first.
    """

    @checked
    def __init__(self, curve: ReferenceCurve, start: Vector3, settle_s: Duration, stages_s: Vector):
        super().__init__()
        self._curve, self._start = curve, start
        self._settle_s, self._stages = settle_s, stages_s
        time = {self.time_ticket()}
        self.DeclareVectorOutputPort("reference", 6, self._calc_reference, time)
        self._horizon = self.DeclareVectorOutputPort(
            "horizon", 6 * len(stages_s), self._calc_horizon, time
        )
        self.DeclareVectorOutputPort("d_g", 1, self._calc_d_g, {self.nothing_ticket()})

    def _calc_reference(self, context: Context, output: BasicVector) -> None:
        # A tick needs both, and the horizon costs no more than this alone.
        output.SetFromVector(self._horizon.Eval(context)[:6])

    def _calc_horizon(self, context: Context, output: BasicVector) -> None:
        now = round(context.get_time() - self._settle_s, 9)  # 0 is exactly 0.
        times = np.full(len(self._stages), now) if now < 0 else now + self._stages
        motion = hover_then_follow(self._curve, self._start, times)
        output.SetFromVector(np.hstack(motion).ravel())

    def _calc_d_g(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([self._curve.diameter_m])
