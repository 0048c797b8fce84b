"""Folder of a mounted arm."""

import json
from pathlib import Path

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.mounting.mount_arm import Mounted, mount_arm
from aerodrake.mounting.request import Request
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput
from aerodrake.support.run_folder import run_folder
from aerodrake.support.threads import single_thread
from aerodrake.support.version import __version__

RESULTS = ("mounting.json",)
"""File that every such folder has."""


def write_vehicle(request: Request, folder: Path) -> Mounted:
    """Writes the vehicle of an arm, its scenario and `mounting.json` into a folder.

    An earlier one in the folder is replaced as a whole. The vehicle has been read back.

    Raises:
        BadInput: as for `mount_arm`, or if the folder cannot be written or has other files.
    """
    with single_thread(), run_folder(folder, RESULTS) as new:
        try:
            mounted = mount_arm(request, new)
            VehicleModel.load(load_scenario(str(new / f"{request.name}.yaml")))
        except BadInput as error:  # The hidden folder is of no use to anyone.
            is_own = not error.source or str(new) in error.source
            source = request.urdf if is_own else error.source
            raise BadInput(source, *error.args[1:]) from None
        content = {
            "version": __version__,
            "source": str(request.urdf),
            "joints": mounted.joints,
            "changes": mounted.changes,
            "choices": mounted.choices,
        }
        text = json.dumps(content, indent=2, ensure_ascii=False)
        (new / RESULTS[0]).write_text(f"{text}\n", encoding="utf-8")
    return mounted
