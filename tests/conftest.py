"""Shared fixtures, the option `--long` and reproducible property tests.

Campaigns run a small sample by default, and completely with

    pytest --long

or `pytest --long tests/scenario/test_load_fuzz.py` for one of them. Then the fixture `long` is
True.
"""

import gc

import hypothesis
import pytest
from threadpoolctl import threadpool_limits

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from tests.browser import DESKTOP, PHONE, chromium, visit

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--long", action="store_true", help="run campaigns completely")


@pytest.fixture(scope="session")
def long(request: pytest.FixtureRequest) -> bool:
    """True if campaigns run completely."""
    return request.config.getoption("--long")


@pytest.fixture(scope="session", autouse=True)
def _single_thread():
    """Limits BLAS to one thread, since synchronisation costs more than small matrices."""
    with threadpool_limits(limits=1):
        yield


@pytest.fixture(scope="module", autouse=True)
def _garbage():
    """Exempts diagrams with Python systems, which are never freed, from garbage collection."""
    yield
    gc.freeze()


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes commands in this process write empty figures and pages without pictures and replay.

    Drawing takes most of the time of a short run.
    """
    for figure in (
        "reports.flight_folder.plot_tracking",
        "comparison.folder.plot_comparison",
    ):
        monkeypatch.setattr(f"aerodrake.{figure}", lambda *arguments: arguments[-1].touch())
    for pictures in ("reports.flight_page.flight_pictures", "comparison.page._pictures"):
        monkeypatch.setattr(f"aerodrake.{pictures}", lambda *_: [])
    for page in ("reports.flight_folder", "comparison.page"):
        monkeypatch.setattr(f"aerodrake.{page}.replay_page", lambda *_: "")


@pytest.fixture
def write(tmp_path):
    """Function that writes a scenario file and returns its path."""

    def write(content: str | bytes, name: str = "flight.yaml") -> str:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return str(path)

    return write


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    return Scenario()


@pytest.fixture(scope="session")
def vehicle(scenario) -> VehicleModel:
    return VehicleModel.load(scenario)


@pytest.fixture(scope="session")
def short_flight():
    """A scenario with online learning, and the log of its flight of 0.6 s."""
    from aerodrake.flight.simulate import FlightSimulation
    from aerodrake.scenario import Clover, Residual, Scenario

    scenario = Scenario(
        name="short",
        duration=0.5,
        settle_s=0.1,
        reference=Clover(start_s=0.2),
        residual=Residual(mode="online", gate_s=0.0),  # Delta is used from the first.
    )
    return scenario, FlightSimulation(scenario).fly()


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def desktop(browser, path):
    with visit(browser, path, DESKTOP) as visited:
        yield visited


@pytest.fixture(scope="module")
def phone(browser, path):
    with visit(browser, path, PHONE, color_scheme="dark") as visited:
        yield visited


@pytest.fixture(params=["desktop", "phone"])
def visited(request):
    """The page in a window of each size."""
    return request.getfixturevalue(request.param)
