"""A signal's handler that raises, as that of Ctrl-C does, ends a call."""

import signal
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import lamella

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no interval timers here")


class Interrupted(Exception):
    """Raised by the handler."""


@pytest.fixture
def alarm():
    """Sets the time until the signal."""

    def raise_it(*_):
        raise Interrupted

    before = signal.signal(signal.SIGALRM, raise_it)
    yield lambda seconds: signal.setitimer(signal.ITIMER_REAL, seconds)
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


def sliced(torus, layer_height):
    return lamella.slice(*torus, layer_height=layer_height, fill_rule="non-zero", offset=0.3)


def long_slice(torus):
    """Takes seconds, and little memory until it is at its end."""
    return sliced(torus, 0.0001)


def next_of_a_stream(torus):
    return next(lamella.stream(*torus, layer_height=0.0001, fill_rule="non-zero", offset=0.3, chunk=10**6))


@pytest.mark.parametrize("call", [long_slice, next_of_a_stream])
def test_a_call_ends_when_a_handler_raises(torus, alarm, call):
    alarm(0.2)
    begun = time.perf_counter()
    with pytest.raises(Interrupted):
        call(torus)
    assert time.perf_counter() - begun < 1.2


def test_calls_of_other_threads_go_on(torus, alarm):
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(sliced, torus, 0.01)
        alarm(0.05)
        with pytest.raises(Interrupted):
            long_slice(torus)
    assert other.result().hash == sliced(torus, 0.01).hash


def test_the_interpreter_is_free_during_a_call(torus):
    steps = 0
    with ThreadPoolExecutor(1) as pool:
        call = pool.submit(sliced, torus, 0.001)
        while not call.done():
            steps += 1
            time.sleep(0.001)
    assert steps > 20
