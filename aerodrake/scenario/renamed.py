"""Scenario keys of earlier versions, which are refused with their replacement."""

import re

RENAMED: dict[str, str] = {"residual.judge_s": "residual.gate_s"}
"""Old dotted key -> new dotted key. A section counts as a key; keys of faults have no index."""

REMOVED: dict[str, str] = {
    "baseline": "put its keys in a file, the baseline of `aerodrake compare`"
}
"""Old dotted key -> what replaces it, as a clause."""


def successor(key: str) -> str:
    """Returns a clause that names what replaces a dotted key; empty if it never existed."""
    plain = re.sub(r"\[\d+\]", "", key)
    if plain in RENAMED:
        return f"renamed to {RENAMED[plain]}"
    return f"removed; {REMOVED[plain]}" if plain in REMOVED else ""
