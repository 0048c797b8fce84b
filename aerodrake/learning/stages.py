"""The stages of data collection, and the flights that the networks are judged on.

As in the paper, the end-effector flies figure eights at several speeds within
the learning space while the base holds still or flies circles of 10 cm radius
at several speeds in three dimensions. The planes of both turn slowly about the
vertical, so that every heading is seen.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from aerodrake.flight.excitation import Excitation, excite
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.residual.collection_motion import joint_motion, turn_about
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import FigureEight, Hover, Lissajous, Payload, Scenario, Wind

SETTLE_S = 5.0
"""s of hover before a stage's motion; nothing is recorded of it."""

START_S = 3.0
"""s in which a stage's motions rise to their pace."""

Role = Literal["training", "validation", "held_out"]


@dataclass(frozen=True)
class Stage:
    """One flight: what the base and the tool do, and in what air.

    Attributes:
        name: Also of its file.
        role: Trained on, used to choose the network, or only to judge it.
        duration_s: Recorded time.
        lap_s: Of the figure eight.
        tilt_rad: Of the figure eight's plane.
        base: What the base does.
        turn_s: In which the plane of the figure eight turns once about the
            vertical, and that of the base's circle the other way round.
        wind: The air.
        payload: At the end-effector.
        seed: Of gusts and sensor noise.
        twin: Name of the same flight in calm air without payload; empty if it is one.
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
    """A circle in a plane tilted about x; a negative speed goes round the other way."""
    lap_s = 2 * math.pi * radius_m / abs(speed_m_s)
    return Lissajous(
        amplitude_m=(
            radius_m,
            radius_m * math.cos(tilt_rad),
            radius_m * math.sin(tilt_rad),
        ),
        period_s=(lap_s,) * 3,
        phase_rad=(math.copysign(math.pi / 2, speed_m_s), 0.0, 0.0),
        start_s=START_S,
    )


def fly_stage(
    scenario: Scenario,
    stage: Stage,
    progress: Callable[[float], None] = lambda simulated_s: None,
) -> Excitation:
    """Flies one stage open loop on the scenario's station.

    Args:
        scenario: Whose vehicle, controllers, sensors and rates; its wind,
            payload and seed are replaced by the stage's.
        stage: What is flown.
        progress: Called with the simulated time in s as it advances.

    Returns:
        The recording, without the hover before it.
    """
    scenario = dataclasses.replace(
        scenario, wind=stage.wind, payload=stage.payload, seed=stage.seed
    )
    vehicle, period = VehicleModel.load(scenario), scenario.rates.mpc_period_s
    hover = round(SETTLE_S / period)
    times = period * (np.arange(hover + round(stage.duration_s / period) + 1) - hover)

    box = np.array(scenario.allocation.learning_space_m)
    length = box[:2].min()
    eight = FigureEight(
        length_m=length,
        width_m=min(length / 2, box[2]),
        tilt_rad=stage.tilt_rad,
        lap_s=stage.lap_s,
        start_s=START_S,
    )
    tool = make_reference(eight, vehicle.p_O).evaluate(times)
    joints = joint_motion(turn_about(vehicle.p_O, tool, times, stage.turn_s), vehicle, period)
    flown = make_reference(stage.base, vehicle.p_B).evaluate(times)
    _, velocity = turn_about(vehicle.p_B, flown, times, -stage.turn_s)
    base = held_acceleration_motion(vehicle.p_B, velocity, period)
    whole = excite(scenario, base, joints, progress)
    return Excitation(*(getattr(whole, f.name)[hover:] for f in dataclasses.fields(whole)))


def paper_stages() -> list[Stage]:
    """All stages and flights of `aerodrake train`.

    Training and validation: 150 s each, in calm air. Held out: other speeds and
    radii, in calm air, in wind that no network has seen, and with a payload.
    """
    laps, tilts = (16.0, 10.0, 7.0, 5.0), (0.0, 0.7, -0.7, 1.5)
    planes = (0.0, 0.8, 1.57, -0.5)
    speeds = (0.04, -0.04, 0.08, -0.08, 0.12, -0.12, 0.16, -0.16, 0.20, -0.20, 0.25, -0.25)
    stages = [
        Stage(f"still_{lap:g}s", "training", 150.0, lap, tilt)
        for lap, tilt in zip(laps, tilts, strict=True)
    ]
    for i, speed in enumerate(speeds):
        # Neighbouring speeds have neither pace nor planes in common.
        lap, tilt, plane = laps[i % 4], tilts[(i + i // 4) % 4], planes[(3 * i + i // 4) % 4]
        base = circle(0.10, speed, plane)
        stages.append(Stage(f"circle_{speed:+.2f}", "training", 150.0, lap, tilt, base))
    stages += [
        Stage("validation_still", "validation", 150.0, 8.0, 1.0),
        Stage("validation_slow", "validation", 150.0, 12.0, 0.3, circle(0.10, 0.06, 0.4)),
        Stage("validation_medium", "validation", 150.0, 8.0, -1.0, circle(0.10, -0.14, -0.9)),
        Stage("validation_fast", "validation", 150.0, 6.0, 1.0, circle(0.10, 0.22, 1.2)),
    ]
    held_out = (
        Stage("still_6s", "held_out", 60.0, 6.0, 0.4),
        Stage("still_13s", "held_out", 60.0, 13.0, -1.2),
        Stage("circle_0.05_m_0.07", "held_out", 60.0, 11.0, 1.5, circle(0.05, -0.07, 0.9)),
        Stage("circle_0.10_m_0.10", "held_out", 60.0, 9.0, 1.1, circle(0.10, 0.10, 0.6)),
        Stage("circle_0.10_m_0.18", "held_out", 60.0, 6.0, -0.4, circle(0.10, -0.18, -1.2)),
        Stage("circle_0.15_m_0.20", "held_out", 60.0, 11.0, 0.2, circle(0.15, 0.20, 0.2)),
    )
    for i, flight in enumerate(held_out):
        stages += weathers(flight, heading_rad=2.4 * i, seed=1000 + i)
    return stages


def quick_stages() -> list[Stage]:
    """A few of them, of 20 s: enough to see that everything works."""
    chosen = (
        *("still_7s", "circle_+0.04", "circle_-0.08", "circle_+0.12", "circle_-0.20"),
        *("circle_+0.25", "validation_slow", "validation_fast"),
        *("still_6s", "still_6s_wind", "still_6s_payload"),
        *("circle_0.10_m_0.18", "circle_0.10_m_0.18_wind", "circle_0.10_m_0.18_payload"),
    )
    return [
        dataclasses.replace(stage, duration_s=20.0, turn_s=20.0)
        for stage in paper_stages()
        if stage.name in chosen
    ]


def weathers(calm: Stage, heading_rad: float, seed: int) -> list[Stage]:
    """A flight in calm air; in a wind of 2 m/s with gusts and without; and with 0.2 kg.

    Args:
        calm: The flight.
        heading_rad: Where the wind blows to.
        seed: Of the gusts.
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
