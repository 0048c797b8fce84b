"""Folders for files that can be made again, whoever the user is and whatever is writable."""

import os
import stat
import tempfile
from collections.abc import Iterable
from pathlib import Path


def user_folder(variable: str, default: str) -> Path | None:
    """Returns a folder of the XDG specification; None if it has no absolute path.

    Args:
        variable: Environment variable that names it, such as XDG_CACHE_HOME.
        default: Its path otherwise, such as ~/.cache. A user without a home has none.
    """
    for name in (os.environ.get(variable, ""), os.path.expanduser(default)):
        if os.path.isabs(name):
            return Path(name)
    return None


def is_writable(folder: Path) -> bool:
    """Returns True if files can be created in a folder, which is created if it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except (OSError, ValueError):  # ValueError: a NUL in the path.
        return False


def private_folder() -> Path | None:
    """Returns this user's folder in the folder of temporary files; None if there is none.

    Later processes of the user find it again. Since files in it are executed, it is not used if
    another user owns it or can write to it.
    """
    try:
        folder = Path(tempfile.gettempdir(), f"aerodrake-{os.getuid()}")
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return None
    is_own = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    return folder if is_own and not status.st_mode & 0o022 and is_writable(folder) else None


def first_writable(folders: Iterable[Path]) -> Path | None:
    """Returns the first folder that is writable; None if there is none."""
    return next(filter(is_writable, folders), None)


def let_matplotlib_cache() -> None:
    """Gives matplotlib a temporary folder if its own folders cannot be written.

    It would otherwise print a warning and list all fonts again in every process.
    """
    own = [os.environ.get("MPLCONFIGDIR")]
    if not own[0]:
        xdg = ("XDG_CACHE_HOME", "~/.cache"), ("XDG_CONFIG_HOME", "~/.config")
        own = [
            folder and folder / "matplotlib" for folder in (user_folder(*names) for names in xdg)
        ]
    if not all(folder and is_writable(Path(folder)) for folder in own):
        temporary = private_folder()
        if temporary:
            os.environ["MPLCONFIGDIR"] = str(temporary / "matplotlib")
