"""Names of the files of a study, which is a sweep or an error budget."""

from dataclasses import dataclass

SCENARIO, ROWS, TIMINGS = "scenario.yaml", "trials.jsonl", "timings.jsonl"


@dataclass(frozen=True)
class StudyFiles:
    """Names of the files of a study.

    Attributes:
        kind: Kind of study, the first part of the names of its own files.
    """

    kind: str

    @property
    def plan(self) -> str:
        """Plan of the study; with `SCENARIO` and the files that it names, its definition."""
        return f"{self.kind}.json"

    @property
    def summary(self) -> str:
        """Summary; an unfinished study has none."""
        return f"{self.kind}_summary.json"

    @property
    def figure(self) -> str:
        """Figure; a study that could not be drawn has none."""
        return f"{self.kind}.png"

    @property
    def results(self) -> tuple[str, ...]:
        """Files that every finished study has."""
        return SCENARIO, self.plan, ROWS, TIMINGS, self.summary

    @property
    def all(self) -> tuple[str, ...]:
        """Files of a finished study."""
        return *self.results, self.figure
