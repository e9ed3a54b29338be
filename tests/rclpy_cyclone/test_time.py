"""Clocks, timers and executors."""

import time

import pytest
from rclpy.clock import Clock, ClockType, JumpThreshold, ROSClock
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMessage


def test_arithmetic_of_times():
    """Times and durations add and compare as rclpy's do, and refuse other clocks."""
    assert Time(seconds=1.5) + Duration(seconds=2) == Time(nanoseconds=3_500_000_000)
    assert (Time(seconds=1) - Time(seconds=3)).nanoseconds == -2_000_000_000
    assert Duration(seconds=-1.5).to_msg().sec == -2
    assert Time.from_msg(Time(seconds=1.5).to_msg()).nanoseconds == 1_500_000_000
    with pytest.raises(TypeError):
        assert Time() < Time(clock_type=ClockType.ROS_TIME)
    with pytest.raises(ValueError):
        Time(seconds=1) - Duration(seconds=2)
    with pytest.raises(OverflowError):
        Time(nanoseconds=2**63)


def test_clock_jumps():
    """Callbacks hear of the jumps beyond their thresholds, and of switches of the source."""
    clock = ROSClock()
    heard = []
    threshold = JumpThreshold(
        min_forward=Duration(nanoseconds=5), min_backward=Duration(nanoseconds=-5)
    )
    handle = clock.create_jump_callback(
        threshold, post_callback=lambda j: heard.append((j.clock_change.name, j.delta.nanoseconds))
    )
    clock.set_ros_time_override(Time(nanoseconds=100, clock_type=ClockType.ROS_TIME))
    clock._set_ros_time_is_active(True)
    for now in (103, 108, 200, 190, 189):
        clock.set_ros_time_override(Time(nanoseconds=now, clock_type=ClockType.ROS_TIME))
    handle.unregister()
    assert heard[0][0] == "ROS_TIME_ACTIVATED"
    same = "ROS_TIME_NO_CHANGE"
    assert heard[1:] == [(same, 5), (same, 92), (same, -10)]


def test_sim_time_moves_clock_and_timers(make_node, spin):
    """With ``use_sim_time`` a node's clock and timers follow ``/clock``, however fast."""
    source = make_node("source")
    node = make_node("n", context=source.context, parameter_overrides=[
        Parameter("use_sim_time", value=True)
    ])  # fmt: skip
    calls = []
    node.create_timer(0.1, lambda: calls.append(node.get_clock().now().nanoseconds))
    pub = source.create_publisher(ClockMessage, "/clock", 10)
    for step in range(1, 51):
        message = ClockMessage()
        message.clock.nanosec = step * 10_000_000
        pub.publish(message)
        now = step * 10_000_000
        assert spin(lambda now=now: node.get_clock().now().nanoseconds == now, node)
        assert spin(lambda due=step // 10: len(calls) >= due, node)
    assert calls == [100_000_000, 200_000_000, 300_000_000, 400_000_000, 500_000_000]


def test_timer_leaves_out_missed_periods(make_node, spin):
    """After a delay a timer is called once, and keeps to its absolute schedule."""
    node = make_node()
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    calls = []
    timer = node.create_timer(0.2, lambda: calls.append(_next_ns(timer)), clock=steady)
    first = _next_ns(timer)
    time.sleep(0.7)
    assert timer.is_ready()
    assert spin(lambda: bool(calls), node)
    begin = time.monotonic()
    spin(lambda: False, node, seconds=0.03)
    # Three periods were missed; meanwhile others may have come.
    assert len(calls) <= 2 + (time.monotonic() - begin) / 0.2
    assert abs((calls[0] - first + 100_000_000) % 200_000_000 - 100_000_000) < 20_000_000
    timer.cancel()
    assert timer.is_canceled() and not timer.is_ready()
    timer.reset()
    assert not timer.is_canceled() and timer.time_until_next_call() > 0


def _next_ns(timer):
    """When a timer is due next, by the monotonic clock.

    What passes between the two looks at the clock makes it too early: the latest of some counts.
    """
    return max(time.monotonic_ns() + timer.time_until_next_call() for _ in range(5))


def test_timer_does_not_drift(make_node, spin):
    """A timer's calls follow the schedule that began with it."""
    node = make_node()
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    due = []
    timer = node.create_timer(0.02, lambda: due.append(_next_ns(timer)), clock=steady)
    begin = _next_ns(timer)
    assert spin(lambda: len(due) >= 40, node)
    # A reading may be off where the machine was busy; their median is not.
    off = sorted((t - begin + 10_000_000) % 20_000_000 - 10_000_000 for t in due)
    assert abs(off[len(off) // 2]) < 1_000_000


def test_idle_executor_sleeps(make_node):
    """An executor with nothing to do uses no processor time."""
    node = make_node()
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    executor.spin_once(timeout_sec=0.05)
    before = time.thread_time()
    executor.spin_once(timeout_sec=1.0)
    assert time.thread_time() - before < 0.1
    executor.shutdown()


def test_spin_ends_with_the_context(make_node):
    """A shutdown from another thread raises ExternalShutdownException out of spin."""
    import threading

    node = make_node()
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    threading.Timer(0.2, node.context.try_shutdown).start()
    with pytest.raises(ExternalShutdownException):
        while True:
            executor.spin_once()


def test_exceptions_leave_spin(make_node):
    """An exception in a callback comes out of spin."""
    node = make_node()

    def fail():
        raise ValueError("boom")

    node.create_timer(0.001, fail)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    with pytest.raises(ValueError, match="boom"):
        executor.spin()
