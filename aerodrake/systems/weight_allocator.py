"""Weight allocation as a system."""

from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.mpc.weight_allocation import AllocatedWeights, Mode, allocate
from aerodrake.scenario import Allocation
from aerodrake.support.arguments import Period, checked


class WeightAllocator(LeafSystem):
    """Computes gamma, mode and weights from the distances d_e, d_o and d_g.

    They are the paper's (eq. 10, 11) with the differences that `allocate` lists beside the
    printed formulas: |gamma| and its floor of 0.2 in w_m, gamma cut at -1, the floor of d_o in
    w_d, the case that the paper does not cover, and hysteresis.

    Ports:
        in `distances` (2): d_e, d_o in m, computed by `KinematicsSystem`.
        in `d_g` (1): m, maximum diameter of the reference trajectory.
        out `weights` (5): `AllocatedWeights`. Direct feedthrough, so that the MPC samples it
            without delay.
    State:
        `mode`: the mode at the last tick, for hysteresis.
    Rate:
        `period`.

    Args:
        config: Boundaries, their hysteresis, and gains.
        period: s.
    """

    @checked
    def __init__(self, config: Allocation, period: Period):
        super().__init__()
        self._config = config
        self._distances = self.DeclareVectorInputPort("distances", 2)
        self._d_g = self.DeclareVectorInputPort("d_g", 1)
        self._x_mode = self.DeclareDiscreteState([Mode.HOVER])
        self._weights = self.DeclareVectorOutputPort(
            "weights",
            5,
            self._calc_weights,
            {self.all_input_ports_ticket(), self.discrete_state_ticket(self._x_mode)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_weights(self, context: Context, output: BasicVector) -> None:
        last = Mode(int(context.get_discrete_state(self._x_mode).value()[0]))
        d_e, d_o = self._distances.Eval(context)
        output.SetFromVector(allocate(self._config, last, d_e, d_o, self._d_g.Eval(context)[0]))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        weights = AllocatedWeights(*self._weights.Eval(context))
        discrete.set_value(self._x_mode, [weights.mode])
