#!/usr/bin/python3
"""The guard between server and base: what the base gets when something hangs, dies or competes."""

import contextlib
import itertools
import os
import signal
import threading
import time
import unittest

import rospy
import rostest
from driven_robot import DrivenRobot, ExePathClient, is_zero, stamped_link
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from sensor_msgs.point_cloud2 import create_cloud_xyz32
from server_process import ServerProcess, pid_of, write_map
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from mesh_msgs import zoo
from mesh_msgs.diagnostics_ros import OK, WARN
from mesh_msgs.testing import process_has_ended, wait_until
from mesh_msgs.testing_ros import HeardDiagnostics, connected

FAR = (1000.0, 0.0)
HELD = 3  # s
GO, TURN, ZERO = "go", "turn", "zero"


def guard_of(name):
    """The node of a server's guard."""
    return f"/{name}_velocity_guard"


def kind_of(twist):
    if is_zero(twist):
        return ZERO
    return GO if twist.linear.x else TURN


def order(kinds):
    """Without repetitions."""
    return [kind for kind, _ in itertools.groupby(kinds)]


class Listener:
    """Every command on the topic: (when, who, what)."""

    def __init__(self):
        self.heard = []
        rospy.Subscriber("/cmd_vel", Twist, self._note, queue_size=1000)

    def _note(self, message):
        who = message._connection_header["callerid"]
        self.heard.append((time.monotonic(), who, kind_of(message)))

    def kinds(self, who=None, begin=0, after=0.0, before=float("inf")):
        """What came, from one node or from all of them."""
        return [
            kind
            for when, node, kind in self.heard[begin:]
            if who in (None, node) and after < when < before
        ]


class VelocityGuardTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.robot, cls.listener = DrivenRobot(), Listener()
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=1)
        cls.clouds = rospy.Publisher("/lidar/points", PointCloud2, queue_size=1)
        cls.links = rospy.Publisher("/robot/tf_static", TFMessage, queue_size=1, latch=True)
        cls.links.publish(TFMessage([stamped_link("base_link", "lidar", 0.0)]))
        cls.clock_goes, cls.sensor_sees, cls.points = True, True, []
        threading.Thread(target=cls.live, daemon=True).start()
        names = ("go", "turn")
        parameters = {
            "controllers": [{"name": n, "type": f"odd/{n.title()}Controller"} for n in names],
            "planners": [{"name": "holding", "type": "odd/Holding"}],
            "holding": {"seconds": HELD},
            "mesh_map": {"mesh_file": write_map(zoo.grid())},
            # Drives outlive what holds them up here.
            "tf_timeout": 100.0,
            "cmd_vel_ignored_tolerance": 0.0,
        }
        cls.servers = {}
        for name, others in {
            "guarded": {},
            "unguarded": {"velocity_guard": False, "concurrent_drives": "refuse"},
            "doomed": {},
            "preempting": {
                "concurrent_drives": "preempt",
                "guard": {"zone_topic": "zone", "zone_box": [0.0, 1.0, -0.5, 0.5, 0.1, 2.0]},
                # Those of the guard, too: relative and absolute names, and not the velocities.
                "remappings": ("zone:=lidar/points", "/tf_static:=robot/tf_static"),
            },
            "simulated": {"guard": {"max_lin_velocity": 0.25}},
        }.items():
            server = ServerProcess(name, wait=False, **parameters, **others)
            cls.addClassCleanup(server.kill)
            cls.servers[name] = server
            if name == "preempting":  # the next one has the time of the tests
                cls.wait_for_servers()
                rospy.set_param("/use_sim_time", True)
        cls.wait_for_servers()
        rospy.delete_param("/use_sim_time")
        cls.clients = {name: ExePathClient(name) for name in cls.servers}

    @classmethod
    def wait_for_servers(cls):
        for name, server in cls.servers.items():
            server.wait_for_server()
            if name != "unguarded":
                wait_until(lambda name=name: pid_of(guard_of(name)), f"the guard of {name}")

    @classmethod
    def live(cls):
        """The simulated time is that of the computer, unless it stands; and what a sensor sees."""
        while not rospy.is_shutdown():
            time.sleep(0.01)
            with contextlib.suppress(rospy.ROSException, ValueError):  # a shutdown closes topics
                if cls.clock_goes:
                    cls.clock.publish(Clock(rospy.Time.from_sec(time.time())))
                if cls.sensor_sees:
                    header = Header(stamp=rospy.Time.now(), frame_id="lidar")
                    cls.clouds.publish(create_cloud_xyz32(header, cls.points))

    def setUp(self):
        self.robot.put()
        self.robot.obeys = True

    def begin(self, server, kind=GO, goal=FAR, **fields):
        """A drive that has begun: its goal's handle."""
        begin = len(self.listener.heard)
        handle = self.clients[server].send(goal, controller=kind, **fields)
        try:
            wait_until(lambda: kind in self.listener.kinds(begin=begin), f"{kind} of {server}")
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.servers[server].output()}") from error
        return handle

    def cancel(self, server, *handles):
        for handle in handles:
            handle.cancel()
        for handle in handles:
            self.clients[server].answer(handle)

    def test_a_planner_that_holds_pythons_lock(self):
        server, first = self.servers["guarded"], len(self.listener.heard)
        drive = self.begin("guarded")
        state, result = server.ask((0.0, 0.0, 0.0), planner="holding")
        self.assertEqual(state, "SUCCEEDED", result.message)
        begin = float(result.message)
        end = begin + HELD
        held = order(self.listener.kinds(guard_of("guarded"), after=begin, before=end))
        # Commands of before, perhaps, and of the moment in which it begins.
        self.assertEqual(held[-1], ZERO, held)
        self.assertLessEqual(held.count(ZERO), 2, held)
        # On a busy machine the guard, too, is away for a moment.
        self.assertLessEqual(set(self.listener.kinds("/guarded", first)), {ZERO})
        # The drive goes on.
        wait_until(lambda: GO in self.listener.kinds(after=end), "the drive")
        self.cancel("guarded", drive)
        self.assertIn("no command for", server.output())

    def test_the_newer_of_two_drives_has_the_robot(self):
        first = self.begin("guarded")
        begin = len(self.listener.heard)
        second = self.begin("guarded", TURN, concurrency_slot=1)
        wait_until(lambda: self.listener.kinds(begin=begin).count(TURN) > 20, "the second drive")
        self.cancel("guarded", second)
        count = len(self.listener.heard)
        wait_until(lambda: GO in self.listener.kinds(begin=count), "the first drive")
        self.cancel("guarded", first)
        kinds = [kind for kind in self.listener.kinds(begin=begin) if kind != ZERO]
        self.assertEqual(order([GO, *kinds]), [GO, TURN, GO])

    def test_a_newer_drive_preempts(self):
        first = self.begin("preempting")
        second = self.begin("preempting", TURN, concurrency_slot=1)
        state, result = self.clients["preempting"].answer(first)
        self.assertEqual((state, result.outcome), ("PREEMPTED", 101), result.message)
        self.assertIn("slot 1", result.message)
        self.cancel("preempting", second)

    def test_a_newer_drive_is_refused(self):
        first = self.begin("unguarded")
        begin = len(self.listener.heard)
        ask = self.clients["unguarded"].ask
        state, result = ask(FAR, controller=TURN, concurrency_slot=1)
        self.assertEqual((state, result.outcome), ("ABORTED", 100), result.message)
        self.assertIn("slot 0", result.message)
        self.assertNotIn(TURN, self.listener.kinds(begin=begin))
        self.cancel("unguarded", first)

    def test_without_a_guard(self):
        self.assertIsNone(pid_of(guard_of("unguarded")))
        begin = len(self.listener.heard)
        self.robot.put()
        state, _ = self.clients["unguarded"].ask((0.5, 0.0))
        self.assertEqual(state, "SUCCEEDED")
        wait_until(lambda: ZERO in self.listener.kinds("/unguarded", begin), "the stop")
        heard = order(self.listener.kinds("/unguarded", begin))
        self.assertEqual((heard[0], heard[-1]), (GO, ZERO))

    def test_quiet_while_nothing_drives(self):
        begin = len(self.listener.heard)
        self.cancel("guarded", self.begin("guarded"))
        who = guard_of("guarded")
        wait_until(lambda: order(self.listener.kinds(who, begin))[-2:] == [GO, ZERO], "zeros")
        self.wait_for_quiet()
        joystick = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
        self.addCleanup(joystick.unregister)
        wait_until(lambda: connected(joystick), "the joystick")
        begin, twist = len(self.listener.heard), Twist()
        twist.angular.z = 1.0
        for _ in range(60):
            joystick.publish(twist)
            time.sleep(0.05)
        self.assertEqual({who for _, who, _ in self.listener.heard[begin:]}, {rospy.get_name()})

    def wait_for_quiet(self):
        def quiet():
            count = len(self.listener.heard)
            time.sleep(1.5)
            return len(self.listener.heard) == count

        wait_until(quiet, "silence on the topic")

    def test_the_guard_is_killed(self):
        drive, who = self.begin("guarded", goal=(3.0, 0.0)), guard_of("guarded")
        server, old = self.servers["guarded"], pid_of(who)
        begin = len(self.listener.heard)
        os.kill(old, signal.SIGKILL)
        # What the old one sent last may come later than the first of them.
        wait_until(lambda: len(self.listener.kinds("/guarded", begin)) > 5, "the server's zeros")
        killed = len(self.listener.heard)
        wait_until(lambda: pid_of(who) not in (None, old), "the next guard")
        wait_until(lambda: GO in self.listener.kinds(who, killed), "the drive")
        heard = self.listener.heard[killed:]
        self.assertEqual(order(kind for _, _, kind in heard)[:2], [ZERO, GO])
        state, result = self.clients["guarded"].answer(drive)
        self.assertEqual(state, "SUCCEEDED", result.message)
        self.assertEqual(set(self.listener.kinds("/guarded")), {ZERO})
        self.assertIn("velocity_guard: it ended with status -9", server.output())

    def test_a_guard_that_is_stuck_is_replaced(self):
        drive, who = self.begin("guarded"), guard_of("guarded")
        old, first = pid_of(who), len(self.listener.heard)
        os.kill(old, signal.SIGSTOP)
        wait_until(lambda: process_has_ended(old), "its end")
        begin = len(self.listener.heard)
        wait_until(lambda: GO in self.listener.kinds(who, begin), "the drive")
        self.cancel("guarded", drive)
        self.assertEqual(order(self.listener.kinds("/guarded", first)), [ZERO])
        output = self.servers["guarded"].output()
        self.assertRegex(output, r"(?s)no sign of life for 0\..*velocity_guard: it did not answer")

    def test_a_guard_that_is_stuck_comes_back(self):
        """Until then the server stops the robot, and the commands that it finds are too old; or it
        is replaced, on a busy machine."""
        drive, who = self.begin("guarded"), guard_of("guarded")
        old, first = pid_of(who), len(self.listener.heard)
        os.kill(old, signal.SIGSTOP)
        try:
            wait_until(lambda: len(self.listener.kinds("/guarded", first)) > 3, "zeros")
        finally:
            begin = len(self.listener.heard)
            with contextlib.suppress(ProcessLookupError):
                os.kill(old, signal.SIGCONT)
        wait_until(lambda: self.listener.kinds(who, begin)[-5:] == [GO] * 5, "the drive")
        came_back, kinds = pid_of(who) == old, order(self.listener.kinds(who, begin))
        self.cancel("guarded", drive)
        self.assertEqual(order(self.listener.kinds("/guarded", first)), [ZERO])
        if came_back:  # and perhaps sent what it was about to send before
            self.assertIn(ZERO, kinds[:2])

    def test_the_collision_zone(self):
        """Somebody stands there, goes, and the sensor ends."""
        drive, who = self.begin("preempting"), guard_of("preempting")
        diagnostics = HeardDiagnostics()
        self.addCleanup(diagnostics.unregister)
        part = f"{who.lstrip('/')}: velocity"
        for name, closed, free, why in (
            ("points", [(0.5, 0.0, 1.0)] * 3, [], "3 points are in the collision zone"),
            ("sensor_sees", 0, 1, "zone_timeout"),
        ):
            setattr(type(self), name, closed)
            self.addCleanup(setattr, type(self), name, free)
            self.gets_nothing_but(ZERO, who)
            diagnostics.expected(part, WARN, why)
            setattr(type(self), name, free)
            self.gets_nothing_but(GO, who)
            diagnostics.expected(part, OK, "velocities of a drive pass")
        self.assertIn("the robot is stopped: ", self.servers["preempting"].output())
        self.cancel("preempting", drive)

    def gets_nothing_but(self, kind, who):
        """From some moment on."""

        def only():
            return set(self.listener.kinds(who)[-20:]) == {kind}

        wait_until(only, f"nothing but {kind}")

    def test_the_clock_stands(self):
        drive, who = self.begin("simulated"), guard_of("simulated")
        with self.robot.lock:
            last = next(twist for twist in reversed(self.robot.commands) if not is_zero(twist))
        self.assertEqual(last.linear.x, 0.25)  # of 0.5 m/s, as limited
        type(self).clock_goes = False
        try:
            self.gets_nothing_but(ZERO, who)
        finally:
            type(self).clock_goes = True
        begin = len(self.listener.heard)
        wait_until(lambda: GO in self.listener.kinds(who, begin), "the drive")
        self.cancel("simulated", drive)
        # On a busy machine, the command is late before the clock is stopped.
        self.assertRegex(
            self.servers["simulated"].output(), "/clock stands|stopped: no command for"
        )

    def test_the_server_is_killed(self):
        who = guard_of("doomed")
        self.begin("doomed")
        guard, begin = pid_of(who), len(self.listener.heard)
        self.servers["doomed"].kill()
        wait_until(lambda: process_has_ended(guard), "the guard's end")
        wait_until(lambda: pid_of(who) is None, "its end for the master")
        heard = order(self.listener.kinds(who, begin))
        self.assertEqual(heard[-1:], [ZERO], heard)
        self.assertGreater(self.listener.kinds(who, begin).count(ZERO), 5)
        self.wait_for_quiet()


if __name__ == "__main__":
    rospy.init_node("velocity_guard_rostest")
    rostest.rosrun("mesh_navigation", "velocity_guard", VelocityGuardTest)
