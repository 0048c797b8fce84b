"""The log of a flight: signals over reference time."""

import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from aerodrake.model.reference.envelope import ReferenceVerdict
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.support.errors import BadInput

STATE = (
    ("quaternion", "4"),
    ("p_B_m", "3"),
    ("q_rad", "n"),
    ("omega_W_rad_s", "3"),
    ("v_B_m_s", "3"),
    ("qdot_rad_s", "n"),
)
"""Keys and widths of the parts of a state."""

DELTA = "delta"
"""Stands in `PORTS` for `delta_m_s` or `delta_m_s2`, the `log_key` of the model's residual."""

PORTS: dict[str, tuple[tuple[str, str], ...]] = {
    "true_state": STATE,
    "sample": tuple((f"measured_{key}", width) for key, width in STATE),
    "state": tuple((f"estimated_{key}", width) for key, width in STATE),
    "specific_force": (("measured_specific_force_m_s2", "3"),),
    "specific_force_stamp": (("specific_force_stamp_s", "1"),),
    "tool_position": (("measured_p_E_m", "3"),),
    "tool_stamp": (("tool_stamp_s", "1"),),
    "external_acceleration": (("external_acceleration_m_s2", "3"),),
    "specific_thrust": (("specific_thrust_m_s2", "1"),),
    "requested_reference": (("p_Ed_m", "3"), ("v_Ed_m_s", "3")),
    "reference": (("followed_p_Ed_m", "3"), ("followed_v_Ed_m_s", "3")),
    "tool_axis_d": (("tool_axis_d", "3"),),
    "segment": (
        ("p_Bd_m", "3"),
        ("q_d_rad", "n"),
        ("v_Bd_m_s", "3"),
        ("qdot_d_rad_s", "n"),
        ("a_Bd_m_s2", "3"),
        ("qddot_d_rad_s2", "n"),
    ),
    "thrust": (("thrust_n", "k"),),
    "thrust_command": (("thrust_command_n", "k"),),
    "joint_torque": (("joint_torque_n_m", "n"),),
    "torque_at_limit": (("torque_at_limit", "n"),),
    "disturbance": (("disturbance_m_s2", "3"), ("disturbance_rad_s2", "3")),
    "saturated": (("saturated", "1"),),
    "wind_force": (("wind_force_n", "3"),),
    "weights": (("gamma", "1"), ("mode", "1"), ("w_q", "1"), ("w_m", "1"), ("w_d", "1")),
    "prediction": (("predicted_p_E_m", "3(N+1)"),),
    "status": (("qp_status", "1"), ("qp_iterations", "1"), ("plan_age_ticks", "1")),
    "delta": ((DELTA, "3"),),
    "prediction_error": (("prediction_error_m_s", "3"),),
    "nominal_prediction_error": (("nominal_prediction_error_m_s", "3"),),
    "mode": (("supervisor_mode", "1"),),
    "cause": (("supervisor_cause", "1"),),
    "conditions": (("conditions", "c"),),
    "sample_health": (("sample_outage_s", "3"), ("sample_verdict", "3")),
    "joint_oscillation": (("joint_oscillation_rad_s", "n"),),
    "position_offset": (("position_offset_m", "3"),),
    "rotor_effectiveness": (("rotor_effectiveness", "k"),),
    "reference_verdict": (("reference_verdict", "1"),),
    "learner_health": (("learner_cause", "1"), ("learner_gated_s", "1")),
    "delta_source": (("delta_source", "1"),),
    "stable_learning_rate": (("stable_learning_rate", "1"),),
}
"""Ports of the closed loop that are logged, and the keys and widths of their parts.

n is the number of joints, k that of rotors, N the horizon, c the number of the supervisor's
conditions. A part of width 1 is logged as a plain series (T,), the others as (T, width).
`requested_reference` is the reference that was asked for, to which errors are relative; `reference`
is the one that the guard passes on, which is another if a fault changes or the guard refuses it.
Both and `tool_axis_d` are evaluated at each sample; the other ports output a state or a
value that each tick computes anyway. From `segment` the log has the setpoints at each sample.
Only a closed loop with an orientation task has `tool_axis_d`; otherwise the log has zeros.

A row has the values before the updates of its time: the sample of that time (`measured_*`), the
estimate from the sample before (`estimated_*`, `external_acceleration`), and the results of the
MPC's last tick. NaN and infinite values are replaced by the last finite ones.
"""

DERIVED = {
    "time_s": "(T,) reference time; negative during the initial hover",
    "p_E_m": "(T, 3) end-effector, from the true state",
    "tool_axis": "(T, 3) direction of the tool's axis in the world, from the true state",
    "tick_ms": "(ticks,) wall time of each tick of the controller: forming and solving",
}
"""Keys that are not of a port, with their meaning."""

PER_TICK = ("tick_ms",)
"""Keys with a row for each tick of the controller; the others have one for each sample."""

ROWS_PER_WRITE = 4096
"""Number of rows that are compressed at a time."""


@dataclass(frozen=True)
class FlightLog(Mapping[str, np.ndarray]):
    """Signals and ending of one flight; a mapping of the keys to the arrays.

    Attributes:
        signals: Arrays by the keys of `PORTS` and `DERIVED`, in their shapes and units: (T, ...)
            with a row for each sample, those of `PER_TICK` for each tick. Each access may read
            from a file.
        exit_reason: `completed`; `hold` or `descend`, the safe mode at the scenario's end;
            `landed` or `stopped`, by the supervisor; `lost`; or `interrupted`.
        exit_cause: Cause in one line; empty if `completed`.
        wall_s: Wall time of the simulation.
        vehicle: The vehicle that flew.
    """

    signals: Mapping[str, np.ndarray]
    exit_reason: str
    exit_cause: str
    wall_s: float
    vehicle: VehicleModel

    def __getitem__(self, key: str) -> np.ndarray:
        return self.signals[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.signals)

    def __len__(self) -> int:
        return len(self.signals)

    @property
    def time_s(self) -> np.ndarray:
        """(T,) reference time in s; negative during the initial hover."""
        return self.signals["time_s"]

    @property
    def is_flown(self) -> np.ndarray:
        """(T,) True from reference time 0 on; all True if the flight ended before."""
        is_flown = self.time_s >= 0
        return is_flown if is_flown.any() else ~is_flown

    @property
    def error_m(self) -> np.ndarray:
        """(T,) distance of the end-effector from the reference that was asked for."""
        return np.linalg.norm(self["p_E_m"] - self["p_Ed_m"], axis=1)

    @property
    def is_followed(self) -> np.ndarray:
        """(T,) True while the reference that was asked for is accepted and followed."""
        if "followed_p_Ed_m" not in self.signals:  # The log of an earlier version.
            return np.ones_like(self.time_s, dtype=bool)
        pairs = [("p_Ed_m", "followed_p_Ed_m"), ("v_Ed_m_s", "followed_v_Ed_m_s")]
        is_same = np.all([(self[a] == self[b]).all(axis=1) for a, b in pairs], axis=0)
        # A row has the verdict before the updates of its time. The next row has that of its tick.
        verdicts = self["reference_verdict"]
        verdicts = np.append(verdicts[1:], verdicts[-1:])
        return is_same & np.isin(verdicts, (ReferenceVerdict.OK, ReferenceVerdict.JUMPED))

    @property
    def followed_error_m(self) -> np.ndarray:
        """(T,) distance of the end-effector from the reference that was followed."""
        if "followed_p_Ed_m" not in self.signals:
            return self.error_m
        return np.linalg.norm(self["p_E_m"] - self["followed_p_Ed_m"], axis=1)

    @property
    def tool_angle_rad(self) -> np.ndarray | None:
        """(T,) angle of the tool's axis to its desired direction; None without orientation task."""
        t, d = self["tool_axis"], self["tool_axis_d"]
        if not d.any():
            return None
        # Accurate for small angles, unlike the arc cosine of the inner product.
        return np.arctan2(np.linalg.norm(np.cross(t, d), axis=1), np.sum(t * d, axis=1))

    @property
    def p_EB_m(self) -> np.ndarray:
        """(T, 3) the end-effector in the base frame; NaN where a state is."""
        back = self["quaternion"] * [-1.0, 1.0, 1.0, 1.0]
        return rotate(back, self["p_E_m"] - self["p_B_m"])

    @property
    def d_o_m(self) -> np.ndarray:
        """(T,) distance of the end-effector from the centre of its learning space."""
        return np.linalg.norm(self.p_EB_m - self.vehicle.p_O, axis=1)

    @property
    def base_error_m(self) -> np.ndarray:
        """(T,) distance of the base from its setpoint."""
        return np.linalg.norm(self["p_B_m"] - self["p_Bd_m"], axis=1)

    def thinned(self, most: int) -> Self:
        """Returns a log, in memory, of `most` samples or fewer, evenly spaced up to the last."""
        stride = -(-len(self.time_s) // most)
        samples = slice((len(self.time_s) - 1) % stride, None, stride)
        signals = {
            key: rows if key in PER_TICK else rows[samples].copy()
            for key, rows in self.signals.items()
        }
        return replace(self, signals=signals)

    def save(self, path: Path) -> None:
        """Writes the signals as a compressed `.npz`, one at a time."""
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for key, rows in self.signals.items():
                header = np.lib.format.header_data_from_array_1_0(np.ascontiguousarray(rows))
                with archive.open(f"{key}.npy", "w", force_zip64=True) as file:
                    np.lib.format.write_array_header_1_0(file, header)
                    for start in range(0, len(rows), ROWS_PER_WRITE):
                        file.write(rows[start : start + ROWS_PER_WRITE].tobytes())

    @classmethod
    def read(cls, path: Path, summary: Mapping[str, Any], vehicle: VehicleModel) -> Self:
        """Opens a log that `save` wrote; each access reads a signal from the file.

        The ending is from the `summary` of the flight.

        Raises:
            BadInput: if the file is missing or damaged.
        """
        try:
            signals = np.load(path, allow_pickle=False)
            is_complete = signals.keys() >= DERIVED.keys() and signals.zip.testzip() is None
        except FileNotFoundError:
            raise BadInput(path, "", "expected a readable file: no such file") from None
        except Exception:  # The exceptions for malformed files are not documented.
            is_complete = False
        if not is_complete:
            raise BadInput(path, "", "expected the log of a flight")
        ending = (summary[key] for key in ("exit_reason", "exit_cause", "wall_s"))
        return cls(signals, *ending, vehicle)


def rotate(quaternion: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Returns (T, 3): vectors r (T, 3), each rotated by its quaternion (T, 4); NaN stays NaN."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        q = quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)
        turn = 2 * np.cross(q[:, 1:], r)
        return r + q[:, :1] * turn + np.cross(q[:, 1:], turn)


def key_columns(sizes: Mapping[str, int], delta_key: str) -> dict[str, int | slice]:
    """Returns the column of each key of width 1, and the slice of columns of each other key.

    Args:
        sizes: Size of each port, in the order in which a sample has them.
        delta_key: Key of Delta.
    """
    fixed = {"1": 1, "3": 3, "4": 4}
    columns: dict[str, int | slice] = {}
    begin = 0
    for port, size in sizes.items():
        parts, start = PORTS[port], begin
        known = sum(fixed.get(width, 0) for _, width in parts)
        open_parts = sum(width not in fixed for _, width in parts)
        open_width = (size - known) // open_parts if open_parts else 0
        for key, width in parts:
            end = start + fixed.get(width, open_width)
            column = start if width == "1" else slice(start, end)
            columns[delta_key if key == DELTA else key] = column
            start = end
        begin += size
    return columns
