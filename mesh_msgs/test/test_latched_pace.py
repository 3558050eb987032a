"""How many messages LatchedTopics gives a subscriber in which time; without ROS."""

from types import SimpleNamespace

from mesh_msgs.ros import QUEUE, _Recipient

INTERVAL = 0.25


def sent_at(recipient, connection, count, begin=100.0):
    """Times at which so many messages are sent."""
    now, times = begin, []
    while len(times) < count:
        pause = recipient.pause(now, INTERVAL)
        if pause > 0.0:
            now += pause
            continue
        key = next(iter(recipient._keys))
        recipient.expect_one(key, now)
        connection.stat_num_msg += 1
        times.append(now)
    return times


def recipient_of(count):
    connection = SimpleNamespace(stat_num_msg=0)
    return _Recipient(connection, range(count)), connection


def test_as_many_at_once_as_a_queue_holds():
    times = sent_at(*recipient_of(QUEUE), QUEUE)
    assert times == [100.0] * QUEUE


def test_no_more_within_the_time_that_a_subscriber_may_be_busy():
    times = sent_at(*recipient_of(11), 11)
    assert times == [100.0] * 4 + [101.0] * 4 + [102.0] * 3
    for first, fifth in zip(times, times[QUEUE:]):
        assert fifth - first >= QUEUE * INTERVAL


def test_each_waits_until_the_one_before_is_written():
    recipient, connection = recipient_of(2)
    assert recipient.pause(100.0, INTERVAL) == 0.0
    recipient.expect_one(0, 100.0)
    for late in (0.0, 0.01, 10.0):
        assert 0.0 < recipient.pause(100.0 + late, INTERVAL) <= 0.02
    connection.stat_num_msg += 1
    assert recipient.pause(100.0, INTERVAL) == 0.0


def test_what_comes_later_is_paced_by_what_was_sent_before():
    recipient, connection = recipient_of(3)
    sent_at(recipient, connection, 3)
    for key in range(3, 6):
        recipient.want(key)
    assert sent_at(recipient, connection, 3, begin=100.5) == [100.5, 101.0, 101.0]


def test_nothing_is_due_where_nothing_waits():
    recipient, connection = recipient_of(1)
    sent_at(recipient, connection, 1)
    assert recipient.pause(100.0, INTERVAL) is None
