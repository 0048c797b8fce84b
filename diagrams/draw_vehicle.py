"""Renders the vehicle at the start of the clover, with the names of its parts, for the README."""

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

import aerodrake
from aerodrake.gallery.camera import Camera
from aerodrake.gallery.vehicle_picture import VehiclePicture
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.vehicle.robot import TOOL_FRAME
from aerodrake.model.vehicle.vehicle import VehicleModel

CAMERA = Camera(
    eye=np.array([0.80, 1.45, 1.72]),
    target=np.array([-0.12, 0.12, 1.335]),
    width=1600,
    height=860,
    view_rad=0.56,
)

ROTOR_NAMES = ((-215, 92), (0, -32), (60, -32), (0, -32))
"""Distance of each rotor's name from its hub, in pixels."""

BLUE, ORANGE = "#1864ab", "#c2410c"
"""Colours of the learning space and of the reference."""


def main() -> None:
    scenario = aerodrake.load_scenario("clover")
    vehicle = VehicleModel.load(scenario)
    times = scenario.reference.start_s + np.linspace(0, scenario.reference.lap_s, 900)
    lap, _ = make_reference(scenario.reference, vehicle.p_E).evaluate(times)
    picture = VehiclePicture(vehicle, lap, CAMERA)

    p_B, tool = vehicle.p_B, picture.frames[TOOL_FRAME]
    space_m, p_O = np.array(scenario.allocation.learning_space_m), p_B + vehicle.p_O
    picture.box(p_O, space_m, BLUE)
    picture.name(
        "learning space around p_O", p_O + [0.5, 0.5, -0.5] * space_m, (900, 730), color=BLUE
    )
    picture.frame(RigidTransform(p_B))
    picture.name("base: frame B at p_B", p_B, (715, 45), start=(0, 0.5))
    picture.frame(tool)
    at_start = "tool: frame E at p_E, which is p_O at the start"
    picture.name(at_start, tool.translation(), (420, 805))
    for i, (hub, beside) in enumerate(zip(vehicle.rotors.p_B, ROTOR_NAMES, strict=True)):
        picture.write(f"rotor {i}", p_B + hub, beside)
    for i, joint in enumerate(vehicle.joint_names):
        origin = picture.frames[joint].translation()
        picture.name(f"q_{i + 1}  {joint}", origin, (20, 430 + 52 * i), start=(1, 0.5))
    picture.name("reference p_Ed(t)", lap[390], (1300, 370), color=ORANGE)

    path = Path(__file__).parent / "vehicle.png"
    picture.figure.savefig(path, metadata={"Software": None})
    print(path)


if __name__ == "__main__":
    main()
