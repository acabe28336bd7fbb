"""Work shared by threads: all take part, what one raises is raised, the others are told to stop."""

import threading

import pytest

from vibrocap.numerics.run.ensemble import share


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_so_many_threads_work_at_once_this_one_among_them(workers):
    meeting, idents = threading.Barrier(workers), []

    def work(stop):
        meeting.wait(timeout=30)  # broken, and raising, unless all are there
        idents.append(threading.get_ident())

    share(work, workers)
    assert len(set(idents)) == workers
    assert threading.get_ident() in idents


def test_what_another_thread_raises_is_raised_here():
    here = threading.get_ident()

    def work(stop):
        if threading.get_ident() != here:
            raise KeyError("of the other")

    with pytest.raises(KeyError, match="of the other"):
        share(work, 2)


def test_the_others_are_told_when_this_thread_is_interrupted():
    here, waits = threading.get_ident(), []

    def work(stop):
        if threading.get_ident() == here:
            raise KeyboardInterrupt
        waits.append(stop.wait(timeout=30))

    with pytest.raises(KeyboardInterrupt):
        share(work, 2)
    assert waits == [True]
