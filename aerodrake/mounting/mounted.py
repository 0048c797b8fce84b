"""Mounted arm, and sentences on the choices for it."""

from collections.abc import Iterator
from dataclasses import dataclass

from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.mounting.agility import cautions
from aerodrake.mounting.listed import listed
from aerodrake.mounting.request import PLACE, Request
from aerodrake.mounting.scenario_yaml import Start
from aerodrake.mounting.vehicle_urdf import VehicleDesign
from aerodrake.mounting.working import Working

INCH_M = 0.0254


@dataclass(frozen=True)
class Mounted:
    """Mounted arm.

    Attributes:
        vehicle: The vehicle.
        working: The arm's working configuration.
        start: The start of a flight.
        joints: Names of the joints, from the base to the tool.
        changes: Sentences on changes of the arm's URDF.
        choices: Sentences on the choices.
    """

    vehicle: VehicleDesign
    working: Working
    start: Start
    joints: tuple[str, ...]
    changes: tuple[str, ...]
    choices: tuple[str, ...] = ()

    @property
    def weight(self) -> float:
        """N, weight of the vehicle."""
        return (self.vehicle.multirotor.mass + self.vehicle.arm.mass) * GRAVITY


def choices(mounted: Mounted, request: Request) -> Iterator[str]:
    """Yields sentences on the choices."""
    vehicle, working = mounted.vehicle, mounted.working
    multirotor, tool, mount = vehicle.multirotor, vehicle.tool, vehicle.mount
    yield f"arm: {vehicle.arm.mass:.3g} kg, moved by {listed(mounted.joints)}"
    axis = " ".join(f"{x:.3g}" for x in tool.direction)
    yield f"tool: link {tool.link} ({tool.reason}), pointing along ({axis}) of its frame"
    if len(request.mount) <= PLACE:
        way = "upside down" if mount.rpy[0] else "as it stands in its file"
        yield f"mount: {-mount.xyz[2]:g} m below the base's origin, {way}, tool in front (y)"
    yield (
        f"multirotor: {multirotor.mass:g} kg, {multirotor.rotors} rotors of up to "
        f"{multirotor.max_thrust:g} N on a circle of {multirotor.radius:g} m; hover takes "
        f"{mounted.start.hover:.0%} of their thrust"
    )
    yield (
        f"base: moment of inertia {multirotor.inertia[0]:.3g} kg m^2 about a horizontal axis, the "
        f"arm {working.inertia / multirotor.inertia[0]:.2g} times that"
    )
    rise, fall = (f"{1000 * lag:.3g}" for lag in multirotor.lag)
    yield (
        f"rotors: {2 * multirotor.disc / INCH_M:.0f} inch, rising with {rise} ms and falling with "
        f"{fall} ms, in proportion to those of the packaged vehicle; set vehicle.rotor to yours"
    )
    yield f"legs: {multirotor.feet:.2f} m deep, so that the vehicle can land with its arm tucked"
    yield from (f"working configuration: {line}" for line in working.lines())
    joint, ratio = mounted.joints[working.weakest[0]], working.weakest[1]
    if ratio > 1:
        yield f"caution: {joint} cannot hold the arm everywhere: up to {ratio:.0%} of its effort"
    limits = [joint.limits for joint in vehicle.arm.moving(tool.link)]
    yield from cautions(working.posture.jacobian, limits)
    if working.overlap:
        links = " and ".join(working.overlap.links)
        depth = f"{1000 * working.overlap.depth:.0f} mm"
        yield f"caution: boxes around {links} overlap by {depth} there"
