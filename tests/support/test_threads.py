"""Libraries have one thread in the context and as many as before after it."""

import pytest
import torch
from threadpoolctl import threadpool_info, threadpool_limits

from aerodrake.support.threads import single_thread


def blas() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture
def two_threads():
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    with threadpool_limits(limits=2):
        yield
    torch.set_num_threads(before)


def test_one_thread_in_the_context_and_the_previous_number_after_it(two_threads):
    before = blas()
    with single_thread():
        assert torch.get_num_threads() == 1 and blas() == {1}
    assert torch.get_num_threads() == 2 and blas() == before


def test_an_error_restores_the_number_of_threads(two_threads):
    before = blas()
    with pytest.raises(KeyboardInterrupt), single_thread():
        raise KeyboardInterrupt
    assert torch.get_num_threads() == 2 and blas() == before


def test_nested_contexts(two_threads):
    with single_thread():
        with single_thread():
            pass
        assert torch.get_num_threads() == 1 and blas() == {1}
