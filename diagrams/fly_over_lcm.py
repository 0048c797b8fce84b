"""Flies in real time, with station and coordinator in two processes connected over LCM."""

import subprocess
import sys


def main(*options: str) -> None:
    """Starts both processes with a scenario and options `--set` and `--lcm`; default: clover."""
    options = options or ("clover", "--lcm", "udpm://239.255.76.67:7667?ttl=0")
    aerodrake = (sys.executable, "-m", "aerodrake")
    coordinator = subprocess.Popen([*aerodrake, "coordinator", *options, "--quiet"])
    try:
        subprocess.run([*aerodrake, "run", *options], check=True)
        coordinator.wait()
    finally:
        coordinator.kill()


if __name__ == "__main__":
    main(*sys.argv[1:])
