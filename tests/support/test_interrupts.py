"""Signals: held back while something is being written, and not for ever."""

import os
import signal
import threading

import pytest

from aerodrake.support.interrupts import SIGNALS, deferred_interrupts, termination_as_interrupt


def send(number: int = signal.SIGINT, times: int = 1) -> None:
    for _ in range(times):
        os.kill(os.getpid(), number)


@pytest.fixture(autouse=True)
def _handlers_are_put_back():
    before = [signal.getsignal(number) for number in SIGNALS]
    yield
    assert [signal.getsignal(number) for number in SIGNALS] == before


@pytest.mark.parametrize("number", SIGNALS)
def test_they_come_where_they_are_asked_for(number):
    with deferred_interrupts() as check:
        check()
        send(number)
        with pytest.raises(KeyboardInterrupt):
            check()


def test_who_never_asks_goes_on_to_the_end(capfd):
    with deferred_interrupts():
        send()
        assert capfd.readouterr().err == ""
        send()
        assert "saving; interrupt again to lose it" in capfd.readouterr().err


def test_the_third_is_not_held_back():
    with pytest.raises(KeyboardInterrupt), deferred_interrupts():
        send(times=2)
        with pytest.raises(KeyboardInterrupt):
            send()
        raise KeyboardInterrupt


def test_termination_is_an_interrupt():
    with pytest.raises(KeyboardInterrupt), termination_as_interrupt():
        send(signal.SIGTERM)


def test_what_is_ignored_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with deferred_interrupts() as check:
            send(times=3)
            check()
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_leave_signals_alone():
    done = []

    def work():
        with deferred_interrupts() as check, termination_as_interrupt():
            check()
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done
