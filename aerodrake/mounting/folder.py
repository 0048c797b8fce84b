"""Folder of a mounted arm."""

import json
from pathlib import Path

from aerodrake.mounting.mount_arm import Mounted, mount_arm
from aerodrake.mounting.request import Request
from aerodrake.support.run_folder import run_folder
from aerodrake.support.threads import single_thread
from aerodrake.support.version import __version__

RESULTS = ("mounting.json",)
"""File that every such folder has."""


def write_vehicle(request: Request, folder: Path) -> Mounted:
    """Writes the vehicle of an arm, its scenario and `mounting.json` into a folder.

    An earlier one in the folder is replaced as a whole.

    Raises:
        BadInput: as for `mount_arm`, or if the folder cannot be written or has other files.
    """
    with single_thread(), run_folder(folder, RESULTS) as new:
        mounted = mount_arm(request, new)
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
