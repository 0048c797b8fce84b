"""Number of concurrent processes."""

import os

from aerodrake.support.errors import BadInput

MOST_JOBS = 1000


def checked_jobs(jobs: int | None) -> int:
    """Returns the number of processes; for None that of the cores.

    Raises:
        BadInput: if it is not a whole number in [1, `MOST_JOBS`].
    """
    if jobs is None:
        return os.cpu_count() or 1
    if isinstance(jobs, bool) or not isinstance(jobs, int) or not 1 <= jobs <= MOST_JOBS:
        raise BadInput("jobs", "", f"expected a whole number in [1, {MOST_JOBS}], got {jobs!r}")
    return jobs
