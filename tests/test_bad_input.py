"""Bad input to the commands: exit code 2, one line that names it, and no files."""

import os
import pickle
from pathlib import Path

import pytest

from aerodrake.cli import main
from aerodrake.scenario import Vehicle
from aerodrake.support.files import locate

HEADER = "t,x,y,z\n"

WEAK = (
    Path(locate(Vehicle().robot))
    .read_text()
    .replace(
        'lower="-1.57079632" upper="2.61799387" effort="4"',
        'lower="-1.57079632" upper="2.61799387" effort="0.1"',
    )
)
"""A robot whose shoulder is too weak for its arm."""

CONTENT = {
    "good.yaml": "duration: 0.1\n",
    "empty.yaml": "",
    "comment.yaml": "# nothing\n",
    "list.yaml": "- 3\n",
    "text.yaml": "hello\n",
    "binary.yaml": b"\x89PNG\r\n\x1a\n\x00\xff",
    "broken.yaml": "mpc: [1,\n",
    "tabs.yaml": "mpc:\n\thorizon: 3\n",
    "unit.yaml": "duration: 10 s\n",
    "nested.yaml": "vehicle: {rotor: {lag_s: 0.02}}\n",
    "section.yaml": "mpc: 15\n",
    "bare.yaml": "reference: clover\n",
    "two_kinds.yaml": "reference: {kind: hover, lap_s: 24}\n",
    "waypoints_without_file.yaml": "reference: {kind: waypoints}\n",
    "empty.csv": "",
    "header_only.csv": HEADER,
    "one_row.csv": HEADER + "0,0,0.2,1.2\n",
    "header.csv": "time,x,y,z\n0,0,0.2,1.2\n1,0,0.2,1.2\n",
    "no_header.csv": "0,0,0.2,1.2\n1,0,0.2,1.2\n",
    "repeated.csv": HEADER + "0,0,0.2,1.2\n1,0,0.2,1.2\n1,0,0.3,1.2\n",
    "descending.csv": HEADER + "0,0,0.2,1.2\n2,0,0.2,1.2\n1,0,0.3,1.2\n",
    "nan.csv": HEADER + "0,0,0.2,1.2\n1,nan,0.2,1.2\n",
    "inf.csv": HEADER + "0,0,0.2,1.2\n1,0,inf,1.2\n",
    "ragged.csv": HEADER + "0,0,0.2,1.2\n1,0,0.2\n",
    "words.csv": HEADER + "0,0,0.2,1.2\n1,east,0.2,1.2\n",
    "binary.csv": b"t,x,y,z\n\x00\xff\xfe\n",
    "turns.csv": "t,ax,ay,az\n0,0,0,-1\n1,0,0,1\n",
    "text.urdf": "hello\n",
    "other.urdf": "<sdf/>\n",
    "no_tool.urdf": '<robot name="x"><link name="base"/></robot>\n',
    "robot.txt": "hello\n",
    "weak.urdf": WEAK,
    "pickle.pt": pickle.dumps({"run": print}),
    "empty.pt": "",
    "file": "",
}  # fmt: skip


def waypoints(file: str) -> list[str]:
    return ["waypoints", "--set", f"reference.file={file}"]


def robot(path: str) -> list[str]:
    return ["hover", "--set", f"vehicle.robot={path}"]


def checkpoint(path: str) -> list[str]:
    return ["hover", "--set", "residual.mode=online", "--set", f"residual.checkpoint={path}"]


def set_(*assignments: str) -> list[str]:
    return ["hover", *(word for assignment in assignments for word in ("--set", assignment))]


RUNS = {
    "unknown_scenario": (["clovr"], "clovr: ", "did you mean 'clover'? (valid: clover, "),
    "no_name": ([""], "no such scenario", "valid: clover"),
    "missing_file": (["missing.yaml"], "missing.yaml: ", "No such file"),
    "folder_as_file": (["./folder"], "folder: ", "Is a directory"),
    "path_with_nul": (["a\0b.yaml"], "b.yaml: "),
    "empty_file": (["empty.yaml"], "empty.yaml: expected a mapping", "empty"),
    "comments_only": (["comment.yaml"], "comment.yaml: expected a mapping", "empty"),
    "list_in_file": (["list.yaml"], "list.yaml: expected a mapping"),
    "text_in_file": (["text.yaml"], "text.yaml: expected a mapping"),
    "binary_file": (["binary.yaml"], "binary.yaml: expected "),
    "broken_yaml": (["broken.yaml"], "broken.yaml: mpc: expected YAML; line 2"),
    "tab_in_yaml": (["tabs.yaml"], "tabs.yaml: expected YAML; line 2"),
    "unit_as_text": (["unit.yaml"], "unit.yaml: duration: expected a number in [0.02, 3600] s"),
    "nested_unknown_key": (["nested.yaml"], "vehicle.rotor.lag_s: unknown key", "'lag_up_s'"),
    "number_for_section": (["section.yaml"], "section.yaml: mpc: expected a mapping"),
    "reference_without_kind": (["bare.yaml"], "bare.yaml: reference: ", "kind", "clover"),
    "key_of_another_kind": (["two_kinds.yaml"], "reference.lap_s: unknown key"),
    "unknown_key": (set_("sed=3"), "--set: sed: unknown key; did you mean 'seed'?"),
    "unknown_section": (set_("mcp.horizon=3"), "--set: mcp: unknown section", "'mpc'"),
    "into_a_number": (set_("duration.x=3"), "--set: duration: unknown section"),
    "set_without_equals": (set_("duration"), "--set: expected dotted.key=value, got 'duration'"),
    "set_without_key": (set_("=3"), "--set: expected dotted.key=value, got '=3'"),
    "set_broken_yaml": (set_("mpc.k_e=[1"), "--set: mpc.k_e: expected YAML"),
    "unknown_kind": (set_("reference.kind=clovr"), "--set: reference.kind: ", "'clover'"),
    "unknown_choice": (set_("flight.interface=velocity"), "flight.interface: ", "trajectory"),
    "nan": (set_("flight.max_tilt_rad=.nan"), "flight.max_tilt_rad: expected a number", "rad"),
    "inf": (set_("flight.max_tilt_rad=.inf"), "flight.max_tilt_rad: expected a number", "rad"),
    "negative": (set_("vehicle.rotor.lag_up_s=-1"), "vehicle.rotor.lag_up_s: ", "[0.001, 1] s"),
    "out_of_range": (set_("mpc.horizon=1"), "mpc.horizon: ", "[2, 200] stages, got 1"),
    "half_a_tick": (set_("mpc.horizon=15.5"), "mpc.horizon: expected a whole number"),
    "truth_for_number": (set_("mpc.horizon=true"), "mpc.horizon: expected a whole number"),
    "list_length": (set_("mpc.k_e=[1, 2]"), "mpc.k_e: expected a list of 3 numbers in 1/s"),
    "list_element": (set_("mpc.k_e=[1, x, 3]"), "mpc.k_e[1]: expected a number"),
    "list_for_number": (set_("seed=[1]"), "seed: expected a whole number"),
    "number_for_list": (set_("vehicle.working_rad=3"), "working_rad: expected a list"),
    "joint_count": (set_("vehicle.working_rad=[0, 0]"), "vehicle.working_rad: expected 6 angles"),
    "joint_limit": (
        set_("vehicle.working_rad=[0, 3, 0, 0, 0, 0]"),
        "vehicle.working_rad[1]: expected shoulder_pitch in [-1.571, 2.618] rad, got 3",
    ),
    "joint_weights": (set_("mpc.w_3_joints=[1, 2]"), "mpc.w_3_joints: expected 1 value, or 6"),
    "no_joint_weights": (set_("mpc.w_2_joints=[]"), "mpc.w_2_joints: expected 1 value, or 6"),
    "no_backlash": (set_("actuation.backlash_rad=[]"), "actuation.backlash_rad: expected 1 value"),
    "half_a_step": (set_("rates.arm_period_s=0.0055"), "rates.arm_period_s: ", "0.001 s"),
    "mpc_between_samples": (set_("rates.mpc_period_s=0.025"), "rates.mpc_period_s: ", "0.01 s"),
    "mpc_faster_than_flight": (
        set_("rates.flight_period_s=0.04"), "rates.mpc_period_s: ", "rates.flight_period_s"
    ),
    "velocity_not_flown": (
        set_("flight.interface=position", "model.kind=velocity_aware"),
        "model.kind: velocity_aware",
    ),
    "rotor_limits": (set_("vehicle.rotor.min_thrust_n=30"), "vehicle.rotor.min_thrust_n: ", " N"),
    "feet_in_the_ground": (
        set_("vehicle.base_position_m=[0, 0, 0.3]"),
        "vehicle.base_position_m[2]: expected 0.38 m or more", "got 0.3 m",
    ),
    "arm_in_the_ground": (
        set_("vehicle.base_position_m=[0, 0, 0.4]", "vehicle.working_rad=[0, 0, 0, 0, 0, 0]"),
        "vehicle.base_position_m[2]: expected 0.", "m or more",
    ),
    "arm_too_heavy": (["hover", "--set", "vehicle.robot=weak.urdf"],
                      "vehicle.working_rad: expected angles at which shoulder_pitch", "0.1 N m"),
    "no_such_rotor": (
        set_("faults=[{kind: rotor_degraded, rotor: 4}]"),
        "faults[0].rotor: expected a rotor of the robot in [0, 3], got 4",
    ),
    "no_such_joint": (
        set_("faults=[{kind: push}, {kind: joint_degraded, joint: 6}]"),
        "faults[1].joint: expected a joint of the robot in [0, 5], got 6",
    ),
    "allocation_order": (set_("allocation.d_h_m=0.5"), "allocation.d_edge_m: ", "d_h_m (0.5 m)"),
    "name_that_leaves": (set_("name=../../elsewhere"), " name: expected ", "elsewhere"),
    "name_with_nul": (set_('name="a\\0b"'), " name: expected "),
    "seed_negative": (["hover", "--seed", "-1"], "--seed: ", "[0, 2147483647], got -1"),
    "seed_text": (["hover", "--seed", "one"], "--seed: ", "expected a whole number", "'one'"),
    "seed_fraction": (["hover", "--seed", "1.5"], "--seed: ", "expected a whole number"),
    "seed_nothing": (["hover", "--seed", ""], "--seed: ", "expected a whole number"),
    "duration_zero": (["hover", "--duration", "0"], "--duration: ", "[0.02, 3600] s, got 0"),
    "duration_nan": (["hover", "--duration", "nan"], "--duration: ", "[0.02, 3600] s"),
    "duration_unit": (["hover", "--duration", "10 s"], "--duration: ", "[0.02, 3600] s"),
    "robot_missing": (robot("missing.urdf"), "vehicle.robot: ", "missing.urdf: ", "No such file"),
    "robot_folder": (robot("folder"), "folder: ", "URDF"),
    "robot_text": (robot("text.urdf"), "text.urdf: cannot be parsed"),
    "robot_other_xml": (robot("other.urdf"), "other.urdf: cannot be parsed"),
    "robot_other_ending": (robot("robot.txt"), "robot.txt: expected a URDF, whose name ends in"),
    "robot_no_tool": (robot("no_tool.urdf"), "no_tool.urdf: expected a frame named 'tool'"),
    "robot_other_package": (robot("package://other/x.urdf"), "package://other/x.urdf", "expected "),
    "robot_no_package": (robot("package://"), "package://", "expected "),
    "robot_leaves_package": (robot("package://aerodrake/../../../../../../../../etc/passwd"),
                             "/etc/passwd", "of a file in the package"),
    "robot_leaves_and_returns": (
        robot("package://aerodrake/../aerodrake/robots/quadrotor_arm6.urdf"),
        "of a file in the package",
    ),
    "waypoints_no_file": (["waypoints_without_file.yaml"],
                          "waypoints_without_file.yaml: reference.file: "),
    "waypoints_missing": (
        waypoints("missing.csv"), "reference.file: ", "missing.csv: ", "No such file"
    ),
    "waypoints_folder": (waypoints("folder"), "folder: ", "Is a directory"),
    "waypoints_nul": (waypoints('"a\\0b"'), "expected "),
    "waypoints_empty": (waypoints("empty.csv"), "empty.csv: row 1: expected the header t,x,y,z"),
    "waypoints_none": (waypoints("header_only.csv"), "header_only.csv: expected at least 2 rows"),
    "waypoints_one": (waypoints("one_row.csv"), "one_row.csv: expected at least 2 rows"),
    "waypoints_header": (waypoints("header.csv"), "header.csv: row 1: expected the header t,x,y,z"),
    "waypoints_no_header": (waypoints("no_header.csv"), "no_header.csv: row 1: "),
    "waypoints_repeated": (waypoints("repeated.csv"), "repeated.csv: row 4: ", "ascend"),
    "waypoints_descending": (waypoints("descending.csv"), "descending.csv: row 4: ", "ascend"),
    "waypoints_nan": (waypoints("nan.csv"), "nan.csv: row 3: expected x in [-1000, 1000] m"),
    "waypoints_inf": (waypoints("inf.csv"), "inf.csv: row 3: expected y in [-1000, 1000] m"),
    "waypoints_ragged": (waypoints("ragged.csv"), "ragged.csv: row 3: expected 4 cells, got 3"),
    "waypoints_words": (waypoints("words.csv"), "words.csv: row 3: expected x", "'east'"),
    "waypoints_binary": (waypoints("binary.csv"), "binary.csv: "),
    "orientation_zero": (["clover_pointing", "--set", "orientation.axis=[0,0,0]"],
                         "orientation.axis: expected a direction", "0.001 or more"),
    "orientation_behind": (["clover_pointing", "--set", "orientation.axis=[0,0,1]"],
                           "orientation: expected an initial direction within 120 deg", "180.0"),
    "orientation_kind": (["hover", "--set", "orientation.kind=up"],
                         "orientation.kind: unknown kind 'up'"),
    "orientation_no_file": (["hover", "--set", "orientation.kind=along"],
                            "orientation.file: expected the path of a CSV file t,ax,ay,az"),
    "orientation_missing": (["hover", "--set", "orientation.kind=along",
                             "--set", "orientation.file=missing.csv"],
                            "orientation.file: ", "missing.csv: ", "such"),
    "orientation_turns": (["hover", "--set", "orientation.kind=along",
                           "--set", "orientation.file=turns.csv"],
                          "turns.csv: after t = 0 s: expected turns of 90 deg or less"),
    "orientation_clik": (["clover_pointing", "--set", "controller=clik"],
                         "orientation.kind: controller clik expects off, got 'fixed'"),
    "checkpoint_missing": (
        checkpoint("missing.pt"), "residual.checkpoint: ", "missing.pt: ", "No such file"
    ),
    "checkpoint_folder": (checkpoint("folder"), "folder: ", "Is a directory"),
    "checkpoint_empty": (checkpoint("empty.pt"), "empty.pt: expected a checkpoint"),
    "checkpoint_pickle": (checkpoint("pickle.pt"), "pickle.pt: expected a checkpoint"),
    "checkpoint_nul": (checkpoint('"a\\0b"'), "expected "),
    "out_file": (["hover", "--out", "file"], "file: expected a folder, got a file"),
    "out_below_file": (["hover", "--out", "file/run"], "file/run: "),
    "out_foreign": (["hover", "--out", "."], ".: holds files that are not of"),
    "out_nowhere": (["hover", "--out", "/proc/run"], "/proc/run: cannot be written: "),
    "out_nul": (["hover", "--out", "a\0b"], "a b: expected a path without a NUL"),
}  # fmt: skip

COMMANDS = {
    "no_command": ([], "COMMAND"),
    "unknown_command": (["fly"], "'fly'", "'run'"),
    "no_scenario": (["run"], "scenario"),
    "set_without_argument": (["run", "hover", "--set"], "--set"),
    "unknown_option": (["run", "hover", "--sed", "3"], "--sed"),
    "two_scenarios": (["run", "hover", "clover"], "clover"),
    "unknown_graph": (["graph", "closed_lop"], "closed_lop", "did you mean 'closed_loop'?"),
    "graph_into_file": (["graph", "mpc", "--out", "file"], "file: "),
    "negative_depth": (["graph", "mpc", "--depth", "-1"], "--depth"),
    "depth_in_words": (["graph", "mpc", "--depth", "two"], "--depth", "'two'"),
}


@pytest.fixture
def content(tmp_path) -> Path:
    for name, text in CONTENT.items():
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    (tmp_path / "folder").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("argv", "expected"),
    [
        *(
            pytest.param(["run", *argv], expected, id=name)
            for name, (argv, *expected) in RUNS.items()
        ),
        *(pytest.param(argv, expected, id=name) for name, (argv, *expected) in COMMANDS.items()),
    ],
)
def test_bad_input_prints_one_line_and_writes_nothing(content, monkeypatch, capfd, argv, expected):
    monkeypatch.chdir(content)
    try:
        code = main(argv)
    except SystemExit as exit:
        code = exit.code
    out, err = capfd.readouterr()
    assert code == 2
    assert err.startswith("aerodrake") and err.endswith("\n")
    assert len(err.splitlines()) == 1 and "Traceback" not in err and "[Errno" not in err
    for part in expected:
        assert part in err
    assert set(os.listdir()) == {*CONTENT, "folder"}


@pytest.mark.parametrize("last", [[], ["--duration", "5"], ["--seed", "1"]])
def test_an_inconsistency_does_not_name_the_last_option(last, capsys):
    inconsistent = set_("flight.interface=position", "model.kind=velocity_aware")
    assert main(["run", *inconsistent, *last]) == 2
    err = capsys.readouterr().err
    assert "model.kind: velocity_aware" in err
    assert not any(err.startswith(f"aerodrake: {option}:") for option in ("--duration", "--seed"))
