"""Collection runs: flights whose samples train, validate and test the network.

As in the paper, the end-effector flies figure eights at several speeds within the learning
space while the base hovers or flies circles of 10 cm radius at several speeds in three
dimensions. The planes of both turn slowly about the vertical, so that the data cover every
heading.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from aerodrake.flight.excitation import excite
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.residual.collection_motion import joint_motion, turn_about
from aerodrake.model.residual.samples import Excitation
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import FigureEight, Hover, Lissajous, Payload, Scenario, Wind

SETTLE_S = 5.0
"""s, hover before the motion of a run, not recorded."""

START_S = 3.0
"""s, time in which the motions of a run reach their full speed."""

Role = Literal["training", "validation", "held_out"]


@dataclass(frozen=True)
class CollectionRun:
    """One flight: motions of base and tool, and disturbances.

    Attributes:
        name: Name of the run and prefix of its file.
        role: Fits the network, selects its epoch, or tests it (`held_out`).
        duration_s: Recorded time.
        lap_s: Time of one lap of the figure eight.
        tilt_rad: Tilt of the figure eight's plane.
        base: Motion of the base.
        turn_s: Time in which the plane of the figure eight turns once about the vertical, and
            that of the base's circle in the opposite sense.
        wind: Wind and gusts.
        payload: Payload at the end-effector.
        seed: Seed of gusts and sensor noise.
        twin: Name of the same run in calm air without payload; empty for that run itself.
    """

    name: str
    role: Role
    duration_s: float
    lap_s: float
    tilt_rad: float
    base: Hover | Lissajous = Hover()
    turn_s: float = 60.0
    wind: Wind = Wind()
    payload: Payload = Payload()
    seed: int = 0
    twin: str = ""


def circle(radius_m: float, speed_m_s: float, tilt_rad: float) -> Lissajous:
    """Returns a circle in a plane tilted about x; a negative speed reverses its sense."""
    lap_s = 2 * math.pi * radius_m / abs(speed_m_s)
    y, z = radius_m * math.cos(tilt_rad), radius_m * math.sin(tilt_rad)
    return Lissajous(
        amplitude_m=(radius_m, abs(y), abs(z)),
        period_s=(lap_s,) * 3,
        phase_rad=(
            math.copysign(math.pi / 2, speed_m_s),
            math.pi if y < 0 else 0.0,
            math.pi if z < 0 else 0.0,
        ),
        start_s=START_S,
    )


def fly_run(scenario: Scenario, run: CollectionRun) -> Excitation:
    """Flies one run in open loop on the scenario's station, with the run's disturbances and seed.

    Returns:
        The recording, without the initial hover.
    """
    scenario = dataclasses.replace(scenario, wind=run.wind, payload=run.payload, seed=run.seed)
    vehicle, period = VehicleModel.load(scenario), scenario.rates.mpc_period_s
    hover = round(SETTLE_S / period)
    times = period * (np.arange(hover + round(run.duration_s / period) + 1) - hover)

    box = np.array(scenario.allocation.learning_space_m)
    length = box[:2].min()
    width = min(length / 2, box[2])
    eight = FigureEight(length, width, run.tilt_rad, lap_s=run.lap_s, start_s=START_S)
    tool = make_reference(eight, vehicle.p_O).evaluate(times)
    joints = joint_motion(turn_about(vehicle.p_O, tool, times, run.turn_s), vehicle, period)
    flown = make_reference(run.base, vehicle.p_B).evaluate(times)
    _, velocity = turn_about(vehicle.p_B, flown, times, -run.turn_s)
    base = held_acceleration_motion(vehicle.p_B, velocity, period)
    return Excitation(*(rows[hover:] for rows in excite(scenario, base, joints)))


def paper_runs() -> list[CollectionRun]:
    """Returns all runs of `aerodrake train`.

    Training and validation: 150 s each, in calm air. Held out: other speeds and
    radii, in calm air, in wind, and with a payload; neither is in the training runs.
    """
    laps, tilts = (16.0, 10.0, 7.0, 5.0), (0.0, 0.7, -0.7, 1.5)
    planes = (0.0, 0.8, 1.57, -0.5)
    speeds = (0.04, -0.04, 0.08, -0.08, 0.12, -0.12, 0.16, -0.16, 0.20, -0.20, 0.25, -0.25)
    runs = [
        CollectionRun(f"still_{lap:g}s", "training", 150.0, lap, tilt)
        for lap, tilt in zip(laps, tilts, strict=True)
    ]
    for i, speed in enumerate(speeds):
        # Adjacent speeds differ in lap time and in both planes.
        lap, tilt, plane = laps[i % 4], tilts[(i + i // 4) % 4], planes[(3 * i + i // 4) % 4]
        base = circle(0.10, speed, plane)
        runs.append(CollectionRun(f"circle_{speed:+.2f}", "training", 150.0, lap, tilt, base))
    runs += [
        CollectionRun("validation_still", "validation", 150.0, 8.0, 1.0),
        CollectionRun("validation_slow", "validation", 150.0, 12.0, 0.3, circle(0.10, 0.06, 0.4)),
        CollectionRun(
            "validation_medium", "validation", 150.0, 8.0, -1.0, circle(0.10, -0.14, -0.9)
        ),
        CollectionRun("validation_fast", "validation", 150.0, 6.0, 1.0, circle(0.10, 0.22, 1.2)),
    ]
    held_out = (
        CollectionRun("still_6s", "held_out", 60.0, 6.0, 0.4),
        CollectionRun("still_13s", "held_out", 60.0, 13.0, -1.2),
        CollectionRun("circle_0.05_m_0.07", "held_out", 60.0, 11.0, 1.5, circle(0.05, -0.07, 0.9)),
        CollectionRun("circle_0.10_m_0.10", "held_out", 60.0, 9.0, 1.1, circle(0.10, 0.10, 0.6)),
        CollectionRun("circle_0.10_m_0.18", "held_out", 60.0, 6.0, -0.4, circle(0.10, -0.18, -1.2)),
        CollectionRun("circle_0.15_m_0.20", "held_out", 60.0, 11.0, 0.2, circle(0.15, 0.20, 0.2)),
    )
    for i, run in enumerate(held_out):
        runs += with_disturbances(run, heading_rad=2.4 * i, seed=1000 + i)
    return runs


def quick_runs() -> list[CollectionRun]:
    """Returns a few of the runs, shortened to 20 s, to test the whole process."""
    chosen = (
        *("still_7s", "circle_+0.04", "circle_-0.08", "circle_+0.12", "circle_-0.20"),
        *("circle_+0.25", "validation_slow", "validation_fast"),
        *("still_6s", "still_6s_wind", "still_6s_payload"),
        *("circle_0.10_m_0.18", "circle_0.10_m_0.18_wind", "circle_0.10_m_0.18_payload"),
    )
    runs = [run for run in paper_runs() if run.name in chosen]
    return [dataclasses.replace(run, duration_s=20.0, turn_s=20.0) for run in runs]


def with_disturbances(calm: CollectionRun, heading_rad: float, seed: int) -> list[CollectionRun]:
    """Returns a calm run, and variants in gusty wind, in steady wind and with a payload of 0.2 kg.

    The wind blows at 2 m/s towards `heading_rad`; `seed` is that of the gusts.
    """
    mean = (2 * math.cos(heading_rad), 2 * math.sin(heading_rad), 0.0)
    changes = {
        "wind": {"wind": Wind(velocity_m_s=mean, gust_m_s=(1.0, 1.0, 1.0)), "seed": seed},
        "steady_wind": {"wind": Wind(velocity_m_s=mean)},
        "payload": {"payload": Payload(mass_kg=0.2)},
    }
    return [calm] + [
        dataclasses.replace(calm, name=f"{calm.name}_{name}", twin=calm.name, **change)
        for name, change in changes.items()
    ]
