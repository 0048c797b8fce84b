"""Drake's parser of URDFs, with its warnings and errors named after the file."""

from importlib import resources
from pathlib import PurePath

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.drake_log import plain, recorded_log, warn_once
from aerodrake.support.errors import BadInput
from aerodrake.support.urdf import SUFFIX

REPLACED = ("While parsing inertia", "While re-expressing")
"""Beginnings of the warnings with which Drake replaces an inertia by another one."""


def parse_urdf(plant: MultibodyPlant, urdf: str, robot: str) -> None:
    """Adds a URDF to an unfinalised plant. A warning is logged once for one process.

    Args:
        plant: The plant.
        urdf: The text of the URDF.
        robot: Its path or URI, for messages.

    Raises:
        BadInput: if Drake cannot parse the URDF, or would replace an inertia in it.
    """
    parser = Parser(plant)
    parser.package_map().AddPackageXml(str(resources.files("aerodrake") / "package.xml"))
    with recorded_log() as warnings:
        try:
            parser.AddModelsFromString(urdf, SUFFIX)
        except (RuntimeError, ValueError, SystemExit) as error:  # Drake's own, and its conditions.
            raise BadInput(robot, "", f"cannot be parsed: {plain(str(error))}") from None
    for warning in map(plain, warnings):
        if warning.startswith(REPLACED):
            raise BadInput(robot, "", f"expected physical inertias: {warning}")
        warn_once(f"{PurePath(robot).name}: {warning}")
