"""Sensor section of a scenario: noise, delay and flaws of each sensor; all exact by default."""

from dataclasses import dataclass, replace
from typing import Self

from aerodrake.scenario.schema import Section, choice, quantity


@dataclass(frozen=True)
class Sampling(Section):
    """Rate, latency and loss of one sensor's samples.

    A sample is delivered at each multiple of the period. It contains the state at an earlier time:
    earlier by the sensor's known delay plus the sample's latency.
    """

    # Period; 0 for that of the sensors (of accelerometer and tool: the vehicle has none).
    period_s: float = quantity(0.0, "s", 0.0, 0.2)
    # Least and largest latency beyond the known delay, drawn uniformly for each sample.
    latency_s: tuple[float, ...] = quantity((0.0, 0.0), "s", 0.0, 0.5, length=2)
    # Probability that a sample does not arrive.
    loss: float = quantity(0.0, "1", 0.0, 1.0)
    # Time stamp: the true time of sampling plus the known delay, or the time of arrival.
    stamp: str = choice("sampling", "arrival")


@dataclass(frozen=True)
class PositionSensor(Sampling):
    """Position and velocity of the base, as by motion capture or visual-inertial odometry."""

    bias_m: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m", -1.0, 1.0, length=3)


@dataclass(frozen=True)
class AttitudeSensor(Sampling):
    """Attitude and angular velocity of the base; all vectors are in the base frame."""

    # Rotation vector from the true to the measured attitude.
    bias_rad: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "rad", -0.2, 0.2, length=3)
    # Bias of the gyroscope at the start, and the random walk that it begins there.
    rate_bias_rad_s: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "rad/s", -1.0, 1.0, length=3)
    rate_drift_rad_s2: float = quantity(0.0, "rad/s/sqrt(s)", 0.0, 1.0)


@dataclass(frozen=True)
class JointSensors(Sampling):
    """Encoders of the joints."""

    # Error of each joint's zero: one value, or one per joint.
    zero_rad: tuple[float, ...] = quantity((0.0,), "rad", -0.2, 0.2)
    # Bits per revolution; 0 for exact angles.
    resolution_bits: int = quantity(0, "bits", 0, 32)
    # Joint rates: exact, or the difference of two measured angles over that of their stamps.
    rate: str = choice("exact", "difference")
    # Time constant of the low-pass filter of these differences; 0 for none.
    rate_filter_s: float = quantity(0.0, "s", 0.0, 1.0)


@dataclass(frozen=True)
class Accelerometer(Sampling):
    """Specific force of the base's origin in the base frame, the mean over each period.

    The known delay is that of the base.
    """

    noise_m_s2: float = quantity(0.0, "m/s^2", 0.0, 10.0)
    # Bias at the start, and the random walk that it begins there.
    bias_m_s2: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m/s^2", -5.0, 5.0, length=3)
    drift_m_s3: float = quantity(0.0, "m/s^2/sqrt(s)", 0.0, 5.0)


@dataclass(frozen=True)
class ToolSensor(Sampling):
    """Position of the tool in the world, by a marker or a camera on the tool."""

    noise_m: float = quantity(0.0, "m", 0.0, 1.0)
    # Known delay.
    delay_s: float = quantity(0.0, "s", 0.0, 0.5)
    # Error of the marker's or camera's mounting, in the frame `tool`.
    mounting_m: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m", -0.2, 0.2, length=3)
    # Largest angle of the tool's axis to straight down at which the tool is seen.
    visible_rad: float = quantity(3.1416, "rad", 0.0, 3.1416)


@dataclass(frozen=True)
class Sensors(Section):
    """Standard deviations of the samples' white noise, per axis, the samples' delay, and the
    flaws of each sensor."""

    position_noise_m: float = quantity(0.0, "m", 0.0, 1.0)
    velocity_noise_m_s: float = quantity(0.0, "m/s", 0.0, 1.0)
    attitude_noise_rad: float = quantity(0.0, "rad", 0.0, 0.2)
    rate_noise_rad_s: float = quantity(0.0, "rad/s", 0.0, 1.0)
    joint_noise_rad: float = quantity(0.0, "rad", 0.0, 0.2)
    # Delay of the base's position, attitude and velocities; joint samples have none.
    base_delay_s: float = quantity(0.0, "s", 0.0, 0.5)
    position: PositionSensor = PositionSensor()
    attitude: AttitudeSensor = AttitudeSensor()
    joints: JointSensors = JointSensors()
    accelerometer: Accelerometer = Accelerometer()
    tool: ToolSensor = ToolSensor()

    @property
    def each(self) -> dict[str, Sampling]:
        """The sections of the single sensors, by name."""
        names = ("position", "attitude", "joints", "accelerometer", "tool")
        return {name: getattr(self, name) for name in names}

    @property
    def without_flaws(self) -> Self:
        """Copy with the same noise and known delay, without the flaws of single sensors."""
        return replace(self, **{name: type(sensor)() for name, sensor in self.each.items()})

    def ticks(self, dt: float) -> tuple[int, ...]:
        """Returns how many periods of `dt` s there are between samples of position, attitude and
        joints: one if they are sampled more often."""
        sensors = (self.position, self.attitude, self.joints)
        return tuple(max(1, round(sensor.period_s / dt)) for sensor in sensors)

    @property
    def times(self) -> dict[str, float]:
        """The times in s that are multiples of the plant's step, by dotted key."""
        times = {
            "sensors.base_delay_s": self.base_delay_s,
            "sensors.tool.delay_s": self.tool.delay_s,
        }
        for name, sensor in self.each.items():
            times[f"sensors.{name}.period_s"] = sensor.period_s
            for i, latency_s in enumerate(sensor.latency_s):
                times[f"sensors.{name}.latency_s[{i}]"] = latency_s
        return times
