"""K_e and weights of the integral model at its own best, the variant `integral_best`."""

from pathlib import Path

from aerodrake.scenario import Scenario, Weights
from aerodrake.scenario.load import MAX_FILE_BYTES
from aerodrake.scenario.plain_yaml import parse
from aerodrake.scenario.schema import build
from aerodrake.support.files import PACKAGE, locate, read_bounded


def load_baseline(scenario: Scenario, file: Path | None = None) -> Weights:
    """Reads the weights of a baseline file; keys that it does not have are at their defaults.

    Args:
        scenario: Its name selects the packaged file if `file` is None. If there is none of this
            name, all weights are at their defaults.
        file: YAML with keys of `Weights`, such as `k_e` and `w_4`.

    Raises:
        BadInput: if the file cannot be read, or is not valid.
    """
    packaged = locate(f"{PACKAGE}scenarios/baselines/{scenario.name}.yaml")
    if file is None and not packaged.is_file():
        return Weights()
    path = file or packaged
    text = read_bounded(path, MAX_FILE_BYTES).decode("utf-8", errors="replace")
    return build(Weights, parse(text, path), path)
