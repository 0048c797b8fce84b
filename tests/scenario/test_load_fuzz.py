"""Fuzzing of the scenario loader: it accepts or refuses any input, by key, within a second.

A sample by default; `pytest --long tests/scenario/test_load_fuzz.py` tries 10,000 inputs.
"""

import re
import time
from dataclasses import replace
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import HealthCheck, given, settings

from aerodrake.scenario import AxisAlong, Flight, Model, Residual, Scenario, Vehicle, Waypoints
from aerodrake.scenario.load import load_with_options, packaged_scenarios
from aerodrake.scenario.plain_yaml import dump, parse
from aerodrake.scenario.schema import as_mapping, build
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import ScenarioError
from aerodrake.support.files import locate

MOST_S = 1.0
"""Processor time for one input, including garbage collection of the whole process."""

TEXTS = {name: path.read_text() for name, path in packaged_scenarios().items()}

PLAIN = [
    "0", "-1", "3", "1e-3", "0.5", "1e308", "-1e400", ".nan", ".inf", "9" * 400, "010", "0x1F",
    "1:30", "1:30:15.5", "1_000", "2020-01-01", "2020-13-45", "10 s", "3 m", "1,5", "٣", "~",
    "true", "no", "off", "y", "''", "'3'", "[]", "{}", "[1, 2, 3]", "[1, x, 3]", "[[1], 2, 3]",
    "[.nan, 0, 0]", "[" + "0, " * 2000 + "0]", "{kind: off}", "{kind: clover}", "{kind: [a]}",
    "{kind: waypoints, file: /dev/zero}", "{kind: along, file: ../../x}", "{x: {y: {z: 1}}}",
    "package://aerodrake/../x", "package://aerodrake//etc/passwd", "package://other/x",
    "../../x", "/", ".", "..", "a/b", "'a\\b'", '"\\0"', '"\\x1b[31m"', '"\\ud800"', "ü",
    "'" + "x" * 5000 + "'",
    "[{kind: push}]", "[{kind: push, force_n: [.nan, 0, 0]}]", "[{kind: sample_nan, group: x}]",
    "[{kind: rotor_degraded, rotor: 15}, {kind: 3}]", "[{start_s: 1}]", "[[{kind: push}]]",
]  # fmt: skip
"""Values in plain YAML, valid and invalid."""

HOSTILE = [
    "[" * 500, "{a: " * 500, "[" * 30 + "]" * 30, "&a [*a, *a]", "*a", "<<: {a: 1}", "!!int '3'",
    "!!python/object/apply:os.system ['touch pwned']", "!!python/name:os.system", "!x 3",
    "!!binary x", "!!timestamp 2020-01-01", "!!set {a}", "? [a]\n: 1", "a: b: c", "\t3", "\x07",
    "\x00", "'", '"\\U99999999"', "|\n  text", ">-\n  text", "%YAML 9.9", "---", "...\n---", "#",
    "{3: 1}", "{~: 1}", "{a: 1, a: 2}", "&a [" + "x, " * 300 + "*a]", "\ufeff", "\u2028", "\x85",
    "9" * 90_000, "x" * 90_000, "[" + "1," * 40_000,
]  # fmt: skip
"""Values that are not plain YAML, or too large."""


def keys(data: dict, above: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Returns the paths of all keys."""
    return [
        path
        for name, value in data.items()
        for path in (
            (*above, name),
            *(keys(value, (*above, name)) if isinstance(value, dict) else ()),
        )
    ]


KEYS = keys(as_mapping(Scenario())) + [
    ("reference", "lap_s"), ("reference", "file"), ("orientation", "axis"), ("faults",),
    ("mpc", "horizn"), ("nonsense",), ("name", "x"), ("x" * 500,), ("<<",), ("on",),
]  # fmt: skip

plain = st.sampled_from(PLAIN) | st.floats().map(repr) | st.integers().map(str)
hostile = st.sampled_from(HOSTILE) | st.text(max_size=20)
paths = st.sampled_from(KEYS)


def block(assignments: dict[tuple[str, ...], str]) -> str:
    """Returns YAML in block style with raw values at paths."""
    sections: dict[str, dict | str] = {}
    for path, value in assignments.items():
        node = sections
        for name in path[:-1]:
            node = node.setdefault(name, {}) if isinstance(node.get(name, {}), dict) else {}
        node[path[-1]] = value

    def lines(node: dict, indent: str) -> str:
        return "".join(
            f"{indent}'{name}':\n{lines(value, indent + '  ')}"
            if isinstance(value, dict)
            else f"{indent}'{name}': {value}\n"
            for name, value in node.items()
        )

    return lines(sections, "")


def campaign(strategy, examples: int):
    """Returns a decorator that runs a check on a number of reproducible inputs."""
    slow = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.function_scoped_fixture]
    return lambda check: settings(max_examples=examples, suppress_health_check=slow)(
        given(strategy)(check)
    )()


def load(path: Path, overrides=()) -> ScenarioError | None:
    """Returns the error of loading a file, or None if the scenario survives a round trip."""
    start = time.thread_time()
    try:
        scenario = load_with_options(str(path), overrides)
    except ScenarioError as error:
        message = str(error)
        assert message.isprintable() and len(message) < 2000
        # A key; or, if no key is known, the line or the type of the whole file.
        whole = r"line \d+|byte \d+|expected a mapping of scenario keys|expected dotted\.key=value"
        assert error.key or re.search(whole + r"|at most \d+ bytes", message), message
        return error
    finally:
        assert time.thread_time() - start < MOST_S
    again = build(Scenario, parse(dump(as_mapping(scenario)), path), path)
    assert replace(again, source=scenario.source) == scenario
    return None


def test_values_of_any_kind_at_any_key(tmp_path, long):
    path, seen = tmp_path / "flight.yaml", []

    @campaign(st.dictionaries(paths, plain, min_size=1, max_size=4), 4000 if long else 150)
    def check(assignments):
        path.write_text(block(assignments))
        error = load(path)
        assert error is None or error.key
        seen.append(error is None)

    assert any(seen) and not all(seen)


def test_hostile_values_at_any_key(tmp_path, long):
    path = tmp_path / "flight.yaml"

    @campaign(
        st.tuples(st.dictionaries(paths, plain, max_size=2), paths, hostile), 2000 if long else 80
    )
    def check(assignments):
        others, place, value = assignments
        path.write_text(block({**others, place: value}), encoding="utf-8", errors="surrogatepass")
        load(path)

    assert not (Path.cwd() / "pwned").exists()


def test_overrides_of_any_kind(tmp_path, long):
    path = tmp_path / "flight.yaml"
    path.write_text(TEXTS["clover_realistic"])
    assignments = st.one_of(
        st.tuples(paths.map(".".join), plain | hostile).map("=".join),
        st.text(st.characters(), max_size=20),
    )

    @campaign(st.lists(assignments, min_size=1, max_size=3), 2000 if long else 80)
    def check(typed):
        load(path, [("--set", assignment) for assignment in typed])


def test_files_of_any_bytes(tmp_path, long):
    """Random bytes, and scenarios of which a part is removed or overwritten."""
    path = tmp_path / "flight.yaml"
    spoilt = st.builds(
        lambda text, start, length, other: text[:start] + other + text[start + length :],
        st.sampled_from([text.encode() for text in TEXTS.values()]),
        st.integers(0, 2000),
        st.integers(0, 50),
        st.binary(max_size=30),
    )

    @campaign(st.binary(max_size=300) | spoilt, 1500 if long else 80)
    def check(content):
        path.write_bytes(content)
        load(path)


CSV = b"t,x,y,z\n0,0,0.2,1.2\n1,0,0.2,1.3\n2,0.1,0.2,1.3\n"


def named(key: str, path: Path) -> Scenario:
    """Returns a scenario that names a file at a key."""
    scenarios = {
        "reference.file": Scenario(reference=Waypoints(file=str(path))),
        "orientation.file": Scenario(orientation=AxisAlong(file=str(path))),
        "vehicle.robot": Scenario(vehicle=Vehicle(robot=str(path))),
        "residual.checkpoint": Scenario(
            flight=Flight(interface="position"),
            model=Model(kind="paper"),
            residual=Residual(mode="offline", checkpoint=str(path)),
        ),
    }
    return replace(scenarios[key], source="flight.yaml")


@pytest.mark.parametrize(
    ("key", "name", "content"),
    [
        ("reference.file", "path.csv", CSV),
        ("orientation.file", "path.csv", b"t,ax,ay,az\n0,0,0,-1\n1,0.1,0,-1\n2,0.1,0.1,-1\n"),
        ("vehicle.robot", "own.urdf", locate(Vehicle().robot).read_bytes()),
        ("residual.checkpoint", "own.pt",
         locate("package://aerodrake/networks/position.pt").read_bytes()),
    ],
)  # fmt: skip
def test_files_that_a_scenario_names(key, name, content, tmp_path, long):
    path = tmp_path / name
    values = [b"nan", b"-1", b"0", b"1e400", b"x", b"", b"\0", b"\xff", b'"', b"<", b"1e-300"]
    spoilt = st.builds(
        lambda place, length, other: (
            content[: int(place * len(content))]
            + other
            + content[int(place * len(content)) + length :]
        ),
        st.floats(0, 1),
        st.integers(0, 20),
        st.sampled_from(values) | st.binary(max_size=10),
    )
    scenario = named(key, path)
    path.write_bytes(content)
    make_closed_loop(scenario)  # It is valid; and modules are imported before times are measured.

    @campaign(spoilt | st.binary(max_size=100), 125 if long else 15)
    def check(content):
        path.write_bytes(content)
        start = time.thread_time()
        try:
            make_closed_loop(scenario)
        except ScenarioError as error:
            assert error.source == "flight.yaml" and error.key.startswith(key.split(".")[0])
            assert str(path) in str(error) or error.key != key
            assert str(error).isprintable() and len(str(error)) < 2000
        assert time.thread_time() - start < MOST_S
