"""Small arms with the traits of real ones, below a multirotor of their size."""

import math
from dataclasses import dataclass
from pathlib import Path

from aerodrake.scenario import Clover, Rotor, Scenario, Vehicle

AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


@dataclass(frozen=True)
class ArmDesign:
    """A serial arm that hangs straight down at zero, and its multirotor.

    Attributes:
        axes: One letter for each joint, from the base to the tool.
        length_m: Length of each link along -z.
        mass_kg: Mass of each link, a thin rod.
        working_rad: Working configuration.
        base_kg: Mass of the base.
        offset_m: Distance along x of each joint from the end of the link before.
        damping: N m s/rad, of each joint.
        rotor_inertia: kg m^2, reflected inertia of each motor.
        effort_n_m: Torque limit of each joint.
        joint_type: `revolute` or `continuous`.
        thickness_m: Radius of gyration of the links about their own axes.
    """

    axes: str
    length_m: tuple[float, ...]
    mass_kg: tuple[float, ...]
    working_rad: tuple[float, ...]
    base_kg: float = 2.5
    offset_m: float = 0.0
    damping: float = 0.0
    rotor_inertia: float = 0.0
    effort_n_m: float = 6.0
    joint_type: str = "revolute"
    thickness_m: float = 0.015


DESIGNS = {
    "light": ArmDesign(  # Light links at the end, whose joints have nearly the same axes.
        axes="zxzxzxz",
        length_m=(0.06, 0.07, 0.07, 0.07, 0.06, 0.05, 0.05),
        mass_kg=(0.22, 0.22, 0.16, 0.16, 0.12, 0.05, 0.02),
        working_rad=(0.0, -0.3, 0.0, 0.9, 0.0, -0.9, 0.0),
        thickness_m=0.006,
    ),
    "desktop": ArmDesign(
        axes="zxxxz",
        length_m=(0.05, 0.12, 0.12, 0.05, 0.05),
        mass_kg=(0.1, 0.12, 0.1, 0.05, 0.03),
        working_rad=(0.0, -0.3, 1.6, -1.0, 0.0),
        base_kg=2.0,
    ),
    "damped": ArmDesign(
        axes="zxxyx",
        length_m=(0.05, 0.12, 0.1, 0.06, 0.06),
        mass_kg=(0.12, 0.12, 0.1, 0.06, 0.04),
        working_rad=(0.0, -0.2, 1.7, 0.0, -1.0),
        base_kg=1.2,
        damping=0.1,
        thickness_m=0.006,
        effort_n_m=2.0,
    ),
    "long": ArmDesign(
        axes="zxxx",
        length_m=(0.12, 0.48, 0.48, 0.3),
        mass_kg=(0.3, 0.25, 0.17, 0.08),
        working_rad=(0.0, -0.2, 1.7, -1.0),
        damping=0.05,
        rotor_inertia=0.024,
        effort_n_m=12.0,
    ),
    "heavy": ArmDesign(
        axes="zxx",
        length_m=(0.1, 0.35, 0.35),
        mass_kg=(0.8, 1.0, 0.8),
        working_rad=(0.0, -0.6, 1.6),
        rotor_inertia=0.02,
        effort_n_m=20.0,
    ),
    "two": ArmDesign(
        axes="xx",
        length_m=(0.2, 0.2),
        mass_kg=(0.2, 0.15),
        working_rad=(-0.3, 1.4),
    ),
    "offset": ArmDesign(
        axes="zxxxzx",
        length_m=(0.05, 0.18, 0.16, 0.05, 0.05, 0.04),
        mass_kg=(0.3, 0.5, 0.25, 0.1, 0.1, 0.02),
        working_rad=(0.3, -0.4, 1.6, -0.6, 0.8, 0.0),
        offset_m=0.04,
    ),
    "continuous": ArmDesign(
        axes="zxxzxz",
        length_m=(0.07, 0.2, 0.1, 0.06, 0.06, 0.1),
        mass_kg=(0.2, 0.25, 0.17, 0.12, 0.12, 0.2),
        working_rad=(0.0, -0.4, 1.7, 0.0, -1.2, 0.0),
        joint_type="continuous",
    ),
}


def arm_scenario(design: ArmDesign, folder: Path) -> Scenario:
    """Returns the start of a clover after 0.5 s of hover, and writes the vehicle's URDF."""
    path = folder / "arm.urdf"
    path.write_text(urdf(design))
    total = design.base_kg + sum(design.mass_kg)
    height = 0.5 + sum(design.length_m)
    return Scenario(
        name="arm",
        duration=1.0,
        settle_s=0.5,
        vehicle=Vehicle(
            robot=str(path),
            base_position_m=(0.0, 0.0, height),
            working_rad=design.working_rad,
            rotor=Rotor(max_thrust_n=round(2.2 * total * 9.81 / 6, 1)),
        ),
        reference=Clover(amplitude_m=0.4, lap_s=18.0, start_s=3.0),
    )


def urdf(design: ArmDesign) -> str:
    """Returns the URDF of the vehicle."""
    moment = 0.03 * design.base_kg
    parts = [_link("base", design.base_kg, 0.0, (moment, moment, 1.9 * moment)), *_rotors()]
    parent, drop = "base", 0.06
    limits = f'effort="{design.effort_n_m}" velocity="3" drake:acceleration="15"'
    for k, (axis, length, mass) in enumerate(
        zip(design.axes, design.length_m, design.mass_kg, strict=True)
    ):
        name, across = f"link_{k}", mass * (length**2 / 12 + design.thickness_m**2)
        along = mass * design.thickness_m**2
        offset = design.offset_m if k else 0.0
        parts += [
            _link(name, mass, -length / 2, (across, across, along)),
            f'<joint name="joint_{k}" type="{design.joint_type}"><parent link="{parent}"/>'
            f'<child link="{name}"/><origin xyz="{offset} 0 {-drop}"/><axis xyz="{AXES[axis]}"/>'
            f'<limit lower="-3" upper="3" {limits}/><dynamics damping="{design.damping}"/></joint>'
            f'<transmission><type>SimpleTransmission</type><joint name="joint_{k}"/>'
            f'<actuator name="motor_{k}"><drake:gear_ratio value="1"/>'
            f'<drake:rotor_inertia value="{design.rotor_inertia}"/></actuator></transmission>',
        ]
        parent, drop = name, length
    parts += [f'<frame name="tool" link="{parent}" xyz="0 0 {-drop}" rpy="0 0 0"/>']
    return '<robot name="arm" xmlns:drake="https://drake.mit.edu">' + "\n".join(parts) + "</robot>"


def _link(name: str, mass: float, centre_m: float, moments: tuple[float, float, float]) -> str:
    ixx, iyy, izz = moments
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 {centre_m}"/><mass value="{mass}"/>'
        f'<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _rotors(count: int = 6, radius_m: float = 0.36) -> list[str]:
    angles = [2 * math.pi * k / count for k in range(count)]
    return [
        f'<frame name="rotor_{k}_{"cw" if k % 2 else "ccw"}" link="base" rpy="0 0 0" '
        f'xyz="{radius_m * math.cos(a):.6f} {radius_m * math.sin(a):.6f} 0.03"/>'
        for k, a in enumerate(angles)
    ]
