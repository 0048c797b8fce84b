"""Interrupts are deferred, up to the third one."""

import os
import signal
import threading

import pytest

from aerodrake.support.interrupts import (
    SIGNALS,
    deferred_interrupts,
    lasting_deferral,
    termination_as_interrupt,
)


def send(number: int = signal.SIGINT, times: int = 1) -> None:
    for _ in range(times):
        os.kill(os.getpid(), number)


@pytest.fixture(autouse=True)
def _handlers_are_restored():
    before = [signal.getsignal(number) for number in SIGNALS]
    yield
    assert [signal.getsignal(number) for number in SIGNALS] == before


@pytest.mark.parametrize("number", SIGNALS)
def test_check_raises_a_deferred_interrupt(number):
    with deferred_interrupts() as check:
        check()
        send(number)
        with pytest.raises(KeyboardInterrupt):
            check()


def test_without_check_the_code_runs_to_its_end(capfd):
    with deferred_interrupts():
        send()
        assert capfd.readouterr().err == ""
        send()
        assert "saving; another interrupt ends the command at once" in capfd.readouterr().err


def test_the_third_interrupt_is_not_deferred():
    with pytest.raises(KeyboardInterrupt), deferred_interrupts():
        send(times=2)
        with pytest.raises(KeyboardInterrupt):
            send()
        raise KeyboardInterrupt


def test_a_deferral_can_last_beyond_its_block():
    """Before it begins, interrupts are raised."""
    with lasting_deferral():
        with pytest.raises(KeyboardInterrupt):
            send()
        with deferred_interrupts() as check:
            send()
            with pytest.raises(KeyboardInterrupt):
                check()
        send()
        with pytest.raises(KeyboardInterrupt):
            send()
    with deferred_interrupts() as check:
        check()


def test_sigterm_raises_keyboard_interrupt():
    with pytest.raises(KeyboardInterrupt), termination_as_interrupt():
        send(signal.SIGTERM)


def test_ignored_signals_stay_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with deferred_interrupts() as check:
            send(times=3)
            check()
    finally:
        signal.signal(signal.SIGINT, before)


def test_without_effect_in_other_threads():
    done = []

    def work():
        with deferred_interrupts() as check, termination_as_interrupt():
            check()
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done
