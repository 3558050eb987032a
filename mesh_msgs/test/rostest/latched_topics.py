#!/usr/bin/python3
"""LatchedTopics with real subscribers, each in a process of its own as RViz would be.

As a subscriber (argument "subscriber") this file does as roscpp does: a thread reads the socket as
fast as it can into a queue of a certain length, of which the oldest message is dropped when it is
full, and a slow callback takes messages from the other end. It prints a line "type value" for each.
"""

import collections
import subprocess
import sys
import threading
import time
import unittest

import numpy as np
import rospy

from mesh_msgs import arrays
from mesh_msgs.ros import INTERVAL, QUEUE, LatchedTopics
from mesh_msgs.testing import wait_until

KEYS = ["layer_%d" % i for i in range(10)]
TIMEOUT = 30.0  # seconds; only reached when something is broken


def subscriber(topic, queue_size, slow, busy):
    """Prints what the callback gets.

    slow: the time that the callback takes, in seconds.
    busy: ... and that it is first not called for, after a message has come.
    """
    rospy.init_node("subscriber", anonymous=True)
    queue = collections.deque(maxlen=queue_size)
    ready = threading.Semaphore(0)

    def enqueue(message):
        queue.append(message)
        ready.release()

    rospy.Subscriber(topic, arrays.MeshVertexCostsStamped, enqueue, queue_size=None)
    while not rospy.is_shutdown():
        if not ready.acquire(timeout=0.1) or not queue:
            continue
        time.sleep(busy)
        busy = 0.0
        message = queue.popleft()
        time.sleep(slow)
        sys.stdout.write("%s %g\n" % (message.type, message.mesh_vertex_costs.costs[0]))
        sys.stdout.flush()


class Peer:
    """A subscriber process; `lines` is what it printed so far."""

    def __init__(self, topic, queue_size=4, slow=0.0, busy=0.0):
        numbers = [str(number) for number in (queue_size, slow, busy)]
        command = [sys.executable, __file__, "subscriber", topic, *numbers]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE)
        self.lines = []
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(line.decode().strip())

    def close(self):
        self.process.kill()
        self.process.wait()
        self._thread.join()
        self.process.stdout.close()

    def wait_for(self, *lines):
        """Whether all of these lines came in time."""
        return wait_until(lambda: set(lines) <= set(self.lines), seconds=TIMEOUT)


def costs(key, value, size=1):
    message = arrays.MeshVertexCostsStamped(type=key)
    message.mesh_vertex_costs.costs = np.full(size, value, np.float32)
    return message


class LatchedTopicsTest(unittest.TestCase):
    """Each test has a topic of its own."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("latched_topics")

    def setUp(self):
        self.topic = "/" + self.id().split(".")[-1]
        self.latched = LatchedTopics(self.topic, arrays.MeshVertexCostsStamped)
        self.peers = []

    def tearDown(self):
        self.latched.unregister()
        for peer in self.peers:
            peer.close()

    def peer(self, **kwargs):
        self.peers.append(Peer(self.topic, **kwargs))
        return self.peers[-1]

    def publish_all(self, value, size=1):
        for key in KEYS:
            self.latched.publish(key, costs(key, value, size))

    def wait_for_connections(self, count):
        there = self.latched.get_num_connections
        wait_until(lambda: there() == count, "%d connections" % count, TIMEOUT)

    def test_a_late_subscriber_gets_every_key_in_order(self):
        self.publish_all(1, size=100_000)
        peer = self.peer()
        self.assertTrue(peer.wait_for(*[key + " 1" for key in KEYS]), peer.lines)
        self.assertEqual(peer.lines, [key + " 1" for key in KEYS])

    def test_a_slow_callback_loses_nothing(self):
        self.publish_all(1)
        peer = self.peer(slow=0.1)
        self.assertTrue(peer.wait_for(*[key + " 1" for key in KEYS]), peer.lines)

    def test_subscribers_that_are_busy_lose_nothing(self):
        """One that is there before anything is published, and one that comes later."""
        early = self.peer(busy=0.8 * QUEUE * INTERVAL)
        self.wait_for_connections(1)
        self.publish_all(1)
        late = self.peer(busy=0.8 * QUEUE * INTERVAL)
        for peer in (early, late):
            self.assertTrue(peer.wait_for(*[key + " 1" for key in KEYS]), peer.lines)
            self.assertEqual(peer.lines, [key + " 1" for key in KEYS])

    def test_a_burst_to_a_connected_slow_subscriber_loses_nothing(self):
        peer = self.peer(slow=0.1)
        self.wait_for_connections(1)
        self.publish_all(1)
        self.assertTrue(peer.wait_for(*[key + " 1" for key in KEYS]), peer.lines)

    def test_a_key_published_again_replaces_the_old_one(self):
        self.publish_all(1)
        self.latched.publish(KEYS[3], costs(KEYS[3], 2))
        self.assertEqual(self.latched.keys(), KEYS)
        peer = self.peer()
        self.assertTrue(peer.wait_for(KEYS[3] + " 2", KEYS[-1] + " 1"), peer.lines)
        self.assertEqual(len(peer.lines), len(KEYS))
        self.latched.publish(KEYS[3], costs(KEYS[3], 3))
        self.assertTrue(peer.wait_for(KEYS[3] + " 3"), peer.lines)

    def test_keys_that_wait_are_sent_once_with_the_newest_message(self):
        peer = self.peer()
        self.wait_for_connections(1)
        begin = time.monotonic()
        for value in range(100):
            self.publish_all(value)
        turns = 1 + int((time.monotonic() - begin) / (QUEUE * INTERVAL))
        self.assertTrue(peer.wait_for(*[key + " 99" for key in KEYS]), peer.lines)
        # Of those before the newest ones, so many at once, and in each turn that publishing took.
        self.assertLessEqual(len(peer.lines), len(KEYS) + QUEUE * turns)

    def test_a_removed_key_is_not_sent_any_more(self):
        self.publish_all(1)
        self.latched.remove(KEYS[2])
        self.latched.remove("unknown")
        peer = self.peer()
        self.assertTrue(peer.wait_for(KEYS[-1] + " 1"), peer.lines)
        self.assertEqual(peer.lines, [key + " 1" for key in KEYS if key != KEYS[2]])

    def test_what_is_kept_goes_to_later_subscribers_only(self):
        early = self.peer()
        self.wait_for_connections(1)
        self.publish_all(1)
        self.assertTrue(early.wait_for(*[key + " 1" for key in KEYS]), early.lines)
        made = []

        def make():
            made.append(threading.current_thread())
            return costs(KEYS[3], 2)

        for _ in range(5):
            self.latched.keep(KEYS[3], make)
        self.assertEqual(self.latched.keys(), KEYS)
        late = self.peer()
        self.assertTrue(late.wait_for(KEYS[-1] + " 1"), late.lines)
        expected = [key + (" 2" if key == KEYS[3] else " 1") for key in KEYS]
        self.assertEqual(late.lines, expected)
        self.assertEqual(len(early.lines), len(KEYS))
        self.latched.send(KEYS[3])
        self.latched.send("unknown")
        self.assertTrue(early.wait_for(KEYS[3] + " 2"), early.lines)
        self.assertEqual(len(made), 1)
        self.assertIsNot(made[0], threading.current_thread())

    def test_what_is_sent_later_is_sent_once_with_the_newest(self):
        peer = self.peer()
        self.latched.publish("b", costs("b", 0))
        self.assertTrue(peer.wait_for("b 0"), peer.lines)  # what is kept is not for it any more
        begin = time.monotonic()
        for value in range(100):
            self.latched.keep("a", lambda value=value: costs("a", value))
            self.latched.send("a", 5.0)
        self.assertTrue(peer.wait_for("a 99"), peer.lines)
        self.assertGreaterEqual(time.monotonic() - begin, 5.0)
        self.latched.publish("b", costs("b", 1))
        self.assertTrue(peer.wait_for("b 1"), peer.lines)
        self.assertEqual(peer.lines, ["b 0", "a 99", "b 1"])
        self.latched.keep("a", lambda: costs("a", 100))
        self.latched.send("a", 3600.0)
        self.latched.send("a")
        self.assertTrue(peer.wait_for("a 100"), peer.lines)

    def test_messages_replaced_faster_than_they_are_made(self):
        peer = self.peer()
        self.wait_for_connections(1)

        def make(value):
            time.sleep(0.05)
            return costs("a", value)

        end, value = time.monotonic() + TIMEOUT, 0
        while not peer.lines and time.monotonic() < end:
            self.latched.keep("a", lambda value=value: make(value))
            self.latched.send("a")
            value += 1
            time.sleep(0.01)
        self.assertTrue(peer.lines)
        self.assertTrue(peer.wait_for("a %d" % (value - 1)), peer.lines)

    def test_a_message_that_cannot_be_made_harms_no_other(self):
        self.publish_all(1)
        self.latched.keep(KEYS[0], lambda: 1 / 0)
        self.latched.keep(KEYS[1], arrays.MeshVertexCosts)
        self.latched.keep(KEYS[2], lambda: None)
        peer = self.peer()
        self.assertTrue(peer.wait_for(*[key + " 1" for key in KEYS[3:]]), peer.lines)
        self.assertEqual(len(peer.lines), len(KEYS) - 3)
        self.assertEqual(self.latched.keys(), KEYS[3:])

    def test_making_a_message_holds_up_nobody(self):
        peer = self.peer()
        self.wait_for_connections(1)
        go = threading.Event()

        def make():
            go.wait(TIMEOUT)
            return costs("slow", 1)

        self.latched.keep("slow", make)
        self.latched.send("slow")
        begin = time.monotonic()
        self.publish_all(1)
        self.assertLess(time.monotonic() - begin, TIMEOUT / 2)
        go.set()
        self.assertTrue(peer.wait_for("slow 1", *[key + " 1" for key in KEYS]), peer.lines)

    def test_a_subscriber_that_leaves_or_stops_reading_holds_up_nobody(self):
        self.publish_all(1, size=5_000_000)
        leaving, stopped, staying = self.peer(), self.peer(), self.peer()
        self.wait_for_connections(3)
        leaving.process.kill()
        stopped.process.send_signal(19)  # SIGSTOP
        self.publish_all(2, size=1000)
        self.assertTrue(staying.wait_for(*[key + " 2" for key in KEYS]), staying.lines)
        self.wait_for_connections(2)

    def test_unregister_ends_the_topic(self):
        self.publish_all(1)
        peer = self.peer()
        self.wait_for_connections(1)
        self.latched.unregister()
        self.latched.unregister()
        self.assertEqual((self.latched.keys(), self.latched.get_num_connections()), ([], 0))
        with self.assertRaisesRegex(rospy.ROSException, "after unregister"):
            self.latched.publish("a", costs("a", 1))
        with self.assertRaisesRegex(rospy.ROSException, "after unregister"):
            self.latched.keep("a", lambda: costs("a", 1))
        with self.assertRaisesRegex(rospy.ROSException, "after unregister"):
            self.latched.send("a")
        self.assertNotIn(self.topic, [name for name, _ in rospy.get_published_topics()])
        self.assertFalse([t for t in threading.enumerate() if t.name.startswith("latched")])
        again = LatchedTopics(self.topic, arrays.MeshVertexCostsStamped)
        again.publish("a", costs("a", 7))
        self.assertTrue(peer.wait_for("a 7"), peer.lines)
        again.unregister()

    def test_wrong_messages_are_refused_and_the_good_one_stays(self):
        self.latched.publish("a", costs("a", 1))
        with self.assertRaisesRegex(TypeError, "expected a mesh_msgs/MeshVertexCostsStamped"):
            self.latched.publish("a", arrays.MeshVertexCosts())
        bad = costs("a", 2)
        bad.uuid = 5
        with self.assertRaisesRegex(ValueError, "uuid: expected a str"):
            self.latched.publish("a", bad)
        good = costs("b", 3)
        self.latched.publish("b", good)
        good.mesh_vertex_costs.costs[:] = 9
        peer = self.peer()
        self.assertTrue(peer.wait_for("a 1", "b 3"), peer.lines)


if __name__ == "__main__":
    if sys.argv[1:2] == ["subscriber"]:
        subscriber(sys.argv[2], int(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5]))
    else:
        import rostest

        rostest.rosrun("mesh_msgs", "latched_topics", LatchedTopicsTest)
