"""Slots: one job replaces another of its slot, other slots go on, nobody waits."""

import threading

from mesh_navigation.server.slots import ConcurrencySlots


class Recorder:
    """Jobs that wait for their cancel and note when they begin and end."""

    def __init__(self):
        self.log = []
        self.begun = {}

    def job(self, name):
        self.begun[name] = threading.Event()

        def run(cancellation):
            self.log.append(f"begin {name}")
            self.begun[name].set()
            cancellation.wait()
            self.log.append(f"end {name}: {cancellation.reason}")

        return run


def test_new_job_cancels_the_old_one_which_ends_first():
    slots, recorder = ConcurrencySlots(), Recorder()
    slots.start(3, recorder.job("a"))
    assert recorder.begun["a"].wait(10)
    second = slots.start(3, recorder.job("b"))
    assert recorder.begun["b"].wait(10)
    second.cancellation.cancel("enough")
    second.join(10)
    reason = "a newer goal took slot 3"
    assert recorder.log == ["begin a", f"end a: {reason}", "begin b", "end b: enough"]


def test_other_slots_go_on():
    slots, recorder = ConcurrencySlots(), Recorder()
    jobs = [slots.start(slot, recorder.job(slot)) for slot in (0, 1, 255)]
    assert all(event.wait(10) for event in recorder.begun.values())
    assert not any(job.cancellation.canceled for job in jobs)
    assert set(slots.cancel_all("over")) == set(jobs)
    for job in jobs:
        job.join(10)
    assert set(recorder.log[3:]) == {f"end {slot}: over" for slot in (0, 1, 255)}


def test_starting_does_not_wait_for_a_job_that_will_not_end():
    slots, stubborn, second = ConcurrencySlots(), threading.Event(), threading.Event()
    slots.start(0, lambda cancellation: stubborn.wait(60))
    job = slots.start(0, lambda cancellation: second.set())
    assert not second.wait(0.05)
    stubborn.set()
    job.join(10)
    assert second.is_set()


def test_a_storm_leaves_one_job_uncanceled():
    slots, ran = ConcurrencySlots(), []
    barrier = threading.Barrier(8)

    def storm(thread):
        barrier.wait()
        for number in range(25):
            jobs.append(slots.start(0, lambda c, key=(thread, number): ran.append((key, c))))

    jobs = []
    threads = [threading.Thread(target=storm, args=(thread,)) for thread in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for job in jobs:
        job.join(10)
    assert len({key for key, _ in ran}) == len(ran) == 200
    assert sum(not job.cancellation.canceled for job in jobs) == 1
    assert not ran[-1][1].canceled
