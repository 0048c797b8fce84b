"""The version is the same wherever it is written, and needs no installation."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import aerodrake

ROOT = Path(aerodrake.__file__).parents[1]


@pytest.mark.parametrize(
    ("file", "pattern"),
    [("aerodrake/package.xml", "<version>(.+)</version>"), ("CITATION.cff", "\nversion: (.+)")],
)
def test_versions_agree(file, pattern):
    assert re.search(pattern, (ROOT / file).read_text())[1] == aerodrake.__version__


def test_the_version_of_a_source_tree(tmp_path):
    """Without the metadata of an installed package."""
    (tmp_path / "aerodrake").symlink_to(Path(aerodrake.__file__).parent)
    code = (
        "import importlib.metadata, sys\n"
        "def version(name): raise importlib.metadata.PackageNotFoundError(name)\n"
        "importlib.metadata.version = version\n"
        f"sys.path.insert(0, {str(tmp_path)!r})\n"
        "import aerodrake\nprint(aerodrake.__version__)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == f"{aerodrake.__version__}\n", done.stderr
