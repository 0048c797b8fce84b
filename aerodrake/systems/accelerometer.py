"""Accelerometer as a system."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.inertial import specific_force, walked
from aerodrake.model.sensing.latency import DRAWS, Delivery
from aerodrake.model.sensing.sample import ACCELEROMETER, INERTIAL_NOISE, split_inertial_noise
from aerodrake.scenario import Accelerometer
from aerodrake.support.arguments import Count, Duration, StateVector, checked
from aerodrake.systems.named_state import NamedState


class AccelerometerState(NamedTuple):
    """State of the accelerometer.

    Attributes:
        samples: (m, 3) m/s^2, the last ones that arrived, the newest first.
        stamp: s, time stamp of the newest; minus infinity before the first.
        bias: (3,) m/s^2.
    """

    samples: np.ndarray
    stamp: float
    bias: np.ndarray


class AccelerometerSystem(LeafSystem):
    """Measures the specific force of the base's origin, and outputs the mean of several samples.

    Ports:
        in `states` (26 + 4 n): true states at both ends of the period that a sample covers.
        in `noise` (9): standard normal draws, in the order of `InertialNoise`.
        in `draws` (10): uniform, for latency and loss.
        out `specific_force` (3): m/s^2 in the base frame, mean of the last `samples` samples.
        out `specific_force_stamp` (1): s, time stamp of the newest of them.
    State:
        the fields of an `AccelerometerState`, a group each.
    Rate:
        `config.period_s`, after `offset`.

    Args:
        config: Noise, bias and drift.
        delivery: Latency and loss.
        samples: Number of samples in a mean.
        offset: s, time of the first sample.
        initial: (13 + 2 n,) the state before the first sample, at rest.
    """

    @checked
    def __init__(
        self,
        config: Accelerometer,
        delivery: Delivery,
        samples: Count,
        offset: Duration,
        initial: StateVector,
    ):
        super().__init__()
        self._config, self._delivery = config, delivery
        self._states = self.DeclareVectorInputPort("states", 2 * len(initial))
        self._noise = self.DeclareVectorInputPort("noise", INERTIAL_NOISE)
        self._draws = self.DeclareVectorInputPort("draws", DRAWS)
        bias = np.array(config.bias_m_s2)
        at_rest = specific_force(initial, initial, config.period_s) + bias
        first = AccelerometerState(np.tile(at_rest, (samples, 1)), -np.inf, bias)
        self._last = NamedState(self, first)
        self.DeclareVectorOutputPort(
            "specific_force",
            3,
            self._calc_mean,
            {self.discrete_state_ticket(self._last.groups["samples"])},
        )
        self.DeclareStateOutputPort("specific_force_stamp", self._last.groups["stamp"])
        self.DeclarePeriodicDiscreteUpdateEvent(config.period_s, offset, self._sample)

    def _calc_mean(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._last.read(context).samples.mean(axis=0))

    def _sample(self, context: Context, discrete: DiscreteValues) -> None:
        last, config = self._last.read(context), self._config
        draws, noise = self._draws.Eval(context), split_inertial_noise(self._noise.Eval(context))
        bias = walked(last.bias, config.drift_m_s3, noise.accelerometer_walk, config.period_s)
        stamp = self._delivery.stamp(ACCELEROMETER, context.get_time(), draws)
        now = last._replace(bias=bias)
        if stamp > last.stamp and not self._delivery.is_lost(ACCELEROMETER, draws):
            before, after = np.split(self._states.Eval(context), 2)
            measured = specific_force(before, after, config.period_s) + bias
            measured += config.noise_m_s2 * noise.accelerometer
            samples = np.vstack([measured, last.samples[:-1]])
            now = now._replace(samples=samples, stamp=stamp)
        self._last.write(discrete, now)
