"""Number of concurrent processes."""

import os

from aerodrake.support.arguments import check_whole
from aerodrake.support.limits import JOBS


def checked_jobs(jobs: int | None) -> int:
    """Returns the number of processes; for None that of the cores.

    Raises:
        BadInput: if it is not a whole number in the range of `JOBS`.
    """
    if jobs is None:
        return os.cpu_count() or 1
    check_whole("jobs", jobs, *JOBS)
    return jobs
