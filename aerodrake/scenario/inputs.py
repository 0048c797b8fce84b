"""Files that a scenario names, copied so that the flown and the saved content are the same."""

import itertools
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from aerodrake.scenario.scenario import Scenario
from aerodrake.scenario.schema import map_files
from aerodrake.support.errors import BadInput, writing
from aerodrake.support.files import read_bounded
from aerodrake.support.scratch import temporary_folder
from aerodrake.support.urdf import SUFFIX, copy_urdf

MAX_BYTES = 20_000_000
"""Largest size of a file that a scenario names."""


@contextmanager
def frozen(scenario: Scenario) -> Iterator[Scenario]:
    """Yields the scenario with temporary copies of its files, which do not change during a flight.

    Errors raised inside the context name the original files.

    Raises:
        BadInput: if the copies cannot be written.
    """
    if not named_files(scenario):
        yield scenario
        return
    with ExitStack() as stack:
        home = stack.enter_context(temporary_folder())
        with writing(home.parent):
            copies = copy_inputs(scenario, home / "inputs")
        originals = dict(zip(named_files(copies), named_files(scenario), strict=True))
        try:
            yield copies
        except BadInput as error:
            parts = list(error.args)
            for copy, original in originals.items():
                parts = [part.replace(copy, original) for part in parts]
            raise type(error)(*parts) from None


def copy_inputs(scenario: Scenario, folder: Path) -> Scenario:
    """Copies each file that a scenario names, except for files in the package.

    Args:
        scenario: Names the files. A file that cannot be read is not copied; its user raises
            the error.
        folder: Created if there are files. A second file of the same name is copied to FOLDER-2.

    Returns:
        The scenario with the paths of the copies.

    Raises:
        OSError: if a copy cannot be written.
    """

    def copy(file: Path) -> Path:
        homes = (folder.with_name(f"{folder.name}-{i}") for i in itertools.count(2))
        home = next(h for h in itertools.chain([folder], homes) if not (h / file.name).exists())
        try:
            home.mkdir(exist_ok=True)
            if file.suffix.lower() == SUFFIX:
                copy_urdf(file, home / file.name)
            else:
                (home / file.name).write_bytes(read_bounded(file, MAX_BYTES))
        except BadInput:
            with suppress(OSError):  # The folder has other files.
                home.rmdir()
            return file
        return home / file.name

    return map_files(scenario, copy)


def named_files(scenario: Scenario | dict[str, Any]) -> list[str]:
    """Returns the paths of the files that a scenario, or some of its fields, name.

    Files in the package are left out.
    """
    paths: list[str] = []

    def collect(file: Path) -> Path:
        paths.append(str(file))
        return file

    map_files(scenario, collect)
    return paths
