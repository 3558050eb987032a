"""Work that nobody waits for: as often as it has to be, by one thread."""

import threading

from mesh_map.costs.background_work import BackgroundWork
from mesh_msgs.testing import wait_until

WAIT = 60.0


def alive(name):
    return [one.name for one in threading.enumerate()].count(name)


def test_what_is_asked_for_meanwhile_is_done_once_more():
    begun, go_on, done = threading.Semaphore(0), threading.Semaphore(0), []

    def work():
        begun.release()
        assert go_on.acquire(timeout=WAIT)
        done.append(threading.get_ident())

    background = BackgroundWork(work, "some work")
    background.ask()
    assert begun.acquire(timeout=WAIT)
    for _ in range(10):
        background.ask()
        assert alive("some work") == 1
    go_on.release()
    assert begun.acquire(timeout=WAIT) and len(done) == 1
    go_on.release()
    assert wait_until(lambda: not alive("some work"))
    assert len(done) == 2 and len(set(done)) == 1
    background.ask()
    go_on.release()
    assert wait_until(lambda: len(done) == 3)


def test_nothing_asked_for_is_lost():
    """Whatever the thread is just doing, such as ending."""
    asked, done, lock = [0], [], threading.Lock()
    background = BackgroundWork(lambda: done.append(asked[0]), "much work")

    def ask():
        for _ in range(300):
            with lock:
                asked[0] += 1
            background.ask()

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(WAIT)
    assert wait_until(lambda: not alive("much work"))
    assert done[-1] == 1200


def test_work_that_fails_is_logged_and_does_not_end_it(caplog):
    errors = [SystemExit("enough"), KeyError("a")]

    def fail():
        raise errors.pop()

    background = BackgroundWork(fail, "bad work")
    for left in (1, 0):
        background.ask()
        assert wait_until(lambda: len(errors) == left and not alive("bad work"))
    assert [one.getMessage() for one in caplog.records] == [
        "bad work: KeyError: 'a'",
        "bad work: SystemExit: enough",
    ]
