"""The files that a scenario names: copied, so that what was flown is what is saved."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from aerodrake.scenario.schema import map_files
from aerodrake.scenario.sections import Scenario
from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded
from aerodrake.support.scratch import scratch_folder
from aerodrake.support.urdf import SUFFIX, copy_urdf

MAX_BYTES = 20_000_000
"""No file that a scenario names is larger."""


@contextmanager
def frozen(scenario: Scenario) -> Iterator[Scenario]:
    """The scenario with copies of its files, which nobody changes while it is flown.

    Errors name the files themselves.

    Raises:
        BadInput: if there is no room for the copies.
    """
    with ExitStack() as stack:
        try:
            home = stack.enter_context(scratch_folder(Path(tempfile.gettempdir())))
            copies = copy_inputs(scenario, home / "inputs")
        except OSError as error:
            raise BadInput("temporary folder", "", f"cannot be written: {error.strerror}") from None
        originals = dict(zip(named_files(copies), named_files(scenario), strict=True))
        try:
            yield copies
        except BadInput as error:
            parts = list(error.args)
            for copy, original in originals.items():
                parts = [part.replace(copy, original) for part in parts]
            raise type(error)(*parts) from None


def copy_inputs(scenario: Scenario, folder: Path) -> Scenario:
    """Copies each file that a scenario names; those in the package stay there.

    Args:
        scenario: What names them. One that cannot be read stays named as it is,
            for whoever needs it to say so.
        folder: Made if there are any; a second of the same name goes to another beside it.

    Returns:
        The scenario with the paths of the copies.

    Raises:
        OSError: if they cannot be written.
    """

    def copy(file: Path) -> Path:
        homes = (folder.with_name(f"{folder.name}-{i}") for i in itertools.count(2))
        home = next(h for h in itertools.chain([folder], homes) if not (h / file.name).exists())
        try:
            home.mkdir(exist_ok=True)
            if file.suffix == SUFFIX:
                copy_urdf(file, home / file.name)
            else:
                (home / file.name).write_bytes(read_bounded(file, MAX_BYTES))
        except BadInput:
            with suppress(OSError):  # Unless there are others in it.
                home.rmdir()
            return file
        return home / file.name

    return map_files(scenario, copy)


def named_files(scenario: Scenario) -> list[str]:
    """The paths of the files that a scenario names, but for those in the package."""
    found: list[str] = []

    def note(file: Path) -> Path:
        found.append(str(file))
        return file

    map_files(scenario, note)
    return found
