"""Plan of an error budget: a scenario with each of its flaws alone, with all, and without each."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Self

from aerodrake.budgets.flaws import Flaw, present_flaws, silence
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop
from aerodrake.support.arguments import check_whole
from aerodrake.support.errors import BadInput
from aerodrake.support.limits import SEED, SEEDS
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import StudyFiles
from aerodrake.sweeps.trial import Trial


class Case(NamedTuple):
    """One set of flaws, flown with one or more seeds.

    Attributes:
        kind: `clean`, `all`, `alone` or `without`.
        flaw: The flaw that is alone, or left out; None for the other kinds.
        silent: Flaws that are silenced.
        is_random: True if flights with other seeds differ.
    """

    kind: str
    flaw: Flaw | None
    silent: tuple[Flaw, ...]
    is_random: bool


@dataclass(frozen=True)
class BudgetPlan(Plan):
    """Plan of an error budget, which has the folder, rows and resumption of a sweep.

    Seeds count up from the scenario's. A case without random flaws is flown with the first alone.

    Attributes:
        seeds: Number of seeds.
    """

    files: ClassVar[StudyFiles] = StudyFiles("budget")

    seeds: int = 1

    @classmethod
    def make(cls, scenario: Scenario, seeds: int) -> Self:
        """Returns the plan for a scenario.

        Raises:
            BadInput: if the scenario has no flaws, or the number of seeds is invalid.
        """
        check_whole("seeds", seeds, *SEEDS)
        if scenario.seed + seeds - 1 > SEED[1]:
            expected = f"expected {SEED[1] - seeds + 1} or less, for {seeds} seeds from it on"
            raise BadInput(scenario.source, "seed", f"{expected}, got {scenario.seed}")
        if not present_flaws(scenario):
            expected = "expected a scenario with flaws, such as clover_field or clover_realistic"
            raise BadInput(
                scenario.source,
                "",
                f"{expected}; sections with flaws are sensors, "
                "actuation, wind, air, payload and mismatch",
            )
        empty = cls(scenario, 0, {}, seeds=seeds)
        return cls(scenario, len(empty.flights), {}, seeds=seeds)

    @cached_property
    def cases(self) -> tuple[Case, ...]:
        """All cases: clean, all, each flaw alone, and all without each."""
        flaws = present_flaws(self.scenario)

        def case(kind: str, flaw: Flaw | None, active: tuple[Flaw, ...]) -> Case:
            silent = tuple(other for other in flaws if other not in active)
            return Case(kind, flaw, silent, any(other.is_random for other in active))

        others = [tuple(other for other in flaws if other != flaw) for flaw in flaws]
        return (
            case("clean", None, ()),
            case("all", None, flaws),
            *(case("alone", flaw, (flaw,)) for flaw in flaws),
            *(case("without", *pair) for pair in zip(flaws, others, strict=True)),
        )

    @cached_property
    def flights(self) -> tuple[tuple[int, int], ...]:
        """Index of the case and seed of each trial; those of a further seed come last."""
        first = self.scenario.seed
        return tuple(
            (index, first + step)
            for step in range(self.seeds)
            for index, case in enumerate(self.cases)
            if case.is_random or step == 0
        )

    def trial(self, index: int) -> Trial:
        """Returns a trial; its parameters are the values that silence flaws."""
        case, seed = self.flights[index]
        return Trial(index, seed, silence(self.cases[case].silent), self.scenario)

    def check(self) -> None:
        """Builds the closed loop with all flaws, which reads the files that the scenario names.

        Raises:
            BadInput: if it cannot be flown.
        """
        make_closed_loop(self.scenario)

    def as_mapping(self) -> dict[str, Any]:
        """Returns the content of `budget.json`; the scenario has a file of its own."""
        return {
            **super().as_mapping(),
            "flaws": [flaw.name for flaw in present_flaws(self.scenario)],
        }
