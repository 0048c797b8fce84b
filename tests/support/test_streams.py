"""Broken standard streams change neither the results nor the exit code more than they must."""

import errno
import io
import json
import os
import pty
import re
import signal
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from aerodrake.cli import main
from aerodrake.support.streams import OutputStream, output_streams

RUN = ["run", "hover", "--set", "settle_s=0", "--duration", "0.05"]
COMMAND = "import sys; from aerodrake.cli import main; sys.exit(main(sys.argv[1:]))"


def without_reader() -> io.TextIOWrapper:
    """Returns a stream into a pipe that nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    return open(writer, "w")


def full() -> io.TextIOWrapper:
    return open("/dev/full", "w")


def closed() -> io.StringIO:
    """Returns a stream that the program itself has closed."""
    stream = io.StringIO()
    stream.close()
    return stream


BROKEN = pytest.mark.parametrize(
    ("make", "reason", "code"),
    [
        (without_reader, "Broken pipe", 141),
        (full, "No space left on device", 1),
        (closed, "I/O operation on closed file", 1),
        (lambda: None, "Bad file descriptor", 1),
    ],
    ids=["no reader", "full", "closed by the program", "closed by the shell"],
)


@BROKEN
def test_an_error_of_the_output_is_one_line_and_one_code(make, reason, code, monkeypatch):
    """A code of the command's own is kept."""
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    stream = OutputStream(make())
    assert stream.exit_code(0) == 0  # Nothing has been written.
    for _ in range(3):
        print("x" * 100_000, file=stream, flush=True)
    assert stream.exit_code(0) == code
    assert sys.stderr.getvalue() == f"aerodrake: cannot write to standard output: {reason}\n"
    assert [stream.exit_code(own) for own in (1, 2, 130)] == [1, 2, 130]


@pytest.mark.parametrize("make", [without_reader, full])
def test_text_in_the_buffer_does_not_fail_at_exit(make):
    stream = make()
    output = OutputStream(stream)
    output.close_broken()  # It is not known to be broken yet.
    print("buffered", file=output)
    assert output.error is None
    output.flush()
    assert output.error.errno in (errno.EPIPE, errno.ENOSPC)
    output.close_broken()
    stream.close()


def test_characters_that_the_encoding_lacks_are_escaped():
    buffer = io.BytesIO()
    output = OutputStream(io.TextIOWrapper(buffer, encoding="ascii"))
    print("runs/ü\udcff 100%|█", file=output, flush=True)
    assert buffer.getvalue() == b"runs/\\xfc\\udcff 100%|\\u2588\n"
    assert output.encoding == "ascii" and output.error is None


def test_streams_are_restored():
    before = sys.stdout, sys.stderr
    with pytest.raises(RuntimeError), output_streams() as output:
        assert sys.stdout is output
        raise RuntimeError
    assert (sys.stdout, sys.stderr) == before


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("output", "errors", "code"),
    [(without_reader, full, 141), (full, without_reader, 1), (lambda: None, lambda: None, 1)],
)
def test_a_flight_with_broken_streams_is_written(output, errors, code, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "stdout", output())
    monkeypatch.setattr(sys, "stderr", errors())
    assert main([*RUN, "--out", str(tmp_path / "results")]) == code
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["exit_reason"] == "completed"


@pytest.mark.parametrize(
    ("words", "code", "expected"),
    [
        ("--version >/dev/full", 1, "cannot write to standard output: No space left on device\n"),
        ("--help | true", 141, "cannot write to standard output: Broken pipe\n"),
        ("run --help >&-", 1, "cannot write to standard output: Bad file descriptor\n"),
        ("--help >/dev/full 2>&1", 1, ""),
        ("run clovr 2>/dev/full", 2, ""),
        ("run clovr <&- 2>&-", 2, ""),
        ("run clovr >&-", 2, "no such scenario"),
        ("fly 2>&-", 2, ""),
    ],
)
def test_exit_codes_of_the_process(words, code, expected, tmp_path):
    shell = f'set -o pipefail; "$0" -c "$1" {words}'
    command = ["bash", "-c", shell, sys.executable, COMMAND]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=100)
    assert (done.returncode, done.stdout) == (code, "")
    assert expected in done.stderr and len(done.stderr.splitlines()) == bool(expected)


def test_files_do_not_become_standard_error():
    """A file that is opened after the start has a descriptor above 2."""
    code = (
        "import os\nfrom aerodrake.support.streams import output_streams\n"
        "with output_streams():\n    print(*(os.fstat(fd).st_rdev for fd in (0, 1, 2)))\n"
        "    file = open(os.devnull)\n    os._exit(file.fileno())"
    )
    done = subprocess.run(["bash", "-c", '"$0" -c "$1" <&- >&- 2>&-', sys.executable, code])
    assert done.returncode > 2


def test_a_terminal_that_vanishes_ends_the_flight_and_keeps_the_results(tmp_path: Path):
    """It sends SIGHUP, and writing to it fails."""
    argv = [sys.executable, "-c", COMMAND, "run", "hover", "--set", "settle_s=0"]
    pid, terminal = pty.fork()
    if pid == 0:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)  # Not ignored, as below nohup.
        os.chdir(tmp_path)
        os.execv(argv[0], [*argv, "--duration", "3000", "--out", "results"])
    termios.tcsetwinsize(terminal, (24, 80))
    output = b""
    while not re.search(rb"[0-9]\.[1-9]/3000\.0 s", output):
        output += os.read(terminal, 1000)
    os.close(terminal)
    _, status = os.waitpid(pid, 0)
    assert os.waitstatus_to_exitcode(status) == 1
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["exit_reason"] == "interrupted"
    assert [path.name for path in tmp_path.iterdir()] == ["results"]
