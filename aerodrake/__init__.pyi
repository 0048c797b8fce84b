from .api.analysis_result import AnalysisResult
from .api.analyze import analyze
from .api.budget import budget
from .api.budget_result import BudgetResult
from .api.compare import compare
from .api.flight_result import FlightResult, load_run
from .api.fly import fly
from .api.identify import identify
from .api.mount import mount
from .api.mount_result import MountResult
from .api.sweep import sweep
from .coordinator import make_coordinator
from .gallery.export import graph
from .model.vehicle.state import VehicleState, split_state
from .reports.live import LiveView
from .scenario.load import load_scenario, override
from .scenario.scenario import Scenario
from .station import make_closed_loop, make_context, make_station
from .support.errors import BadInput, ProcessDied, ScenarioError
from .support.version import __version__
from .wiring.replacements import Replacements

__all__ = [
    "AnalysisResult",
    "BadInput",
    "BudgetResult",
    "FlightResult",
    "LiveView",
    "MountResult",
    "ProcessDied",
    "Replacements",
    "Scenario",
    "ScenarioError",
    "VehicleState",
    "__version__",
    "analyze",
    "budget",
    "compare",
    "fly",
    "graph",
    "identify",
    "load_run",
    "load_scenario",
    "make_closed_loop",
    "make_context",
    "make_coordinator",
    "make_station",
    "mount",
    "override",
    "split_state",
    "sweep",
]
