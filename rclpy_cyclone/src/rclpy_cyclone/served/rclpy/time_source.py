"""Where a node's clock gets its time from: the system, or ``/clock``."""

from __future__ import annotations

import weakref
from typing import Any

from rcl_interfaces.msg import SetParametersResult

from rclpy.clock import ROSClock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time

CLOCK_TOPIC = "/clock"
USE_SIM_TIME_NAME = "use_sim_time"


class TimeSource:
    """Follows a node's ``use_sim_time`` and sets clocks by ``/clock``.

    :param node: the node, which may be attached later.
    """

    def __init__(self, *, node: Any = None) -> None:
        self._clock_sub: Any = None
        self._node_ref: Any = None
        self._clocks: list[ROSClock] = []
        self._last = 0  # the time last heard, in nanoseconds; 0: none yet
        self._active = False
        if node is not None:
            self.attach_node(node)

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clocks show simulated time."""
        return self._active

    @ros_time_is_active.setter
    def ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._active:
            return
        self._active = enabled
        for clock in self._clocks:
            clock._set_ros_time_is_active(enabled)
        node = self._node()
        if enabled and self._clock_sub is None and node is not None:
            self._subscribe(node)
        elif not enabled and self._clock_sub is not None and node is not None:
            node.destroy_subscription(self._clock_sub)
            self._clock_sub = None

    def _subscribe(self, node: Any) -> None:
        from rosgraph_msgs.msg import Clock

        profile = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._clock_sub = node.create_subscription(Clock, CLOCK_TOPIC, self.clock_callback, profile)

    def _node(self) -> Any:
        return self._node_ref() if self._node_ref is not None else None

    def attach_node(self, node: Any) -> None:
        """Follow a node's ``use_sim_time``, declaring it if need be.

        :raises TypeError: if it is no node.
        """
        # Not by its class: `Node` makes a time source, and its module knows this one.
        if not hasattr(node, "create_subscription") or not hasattr(node, "get_parameter"):
            raise TypeError("Node must be of type rclpy.node.Node")
        if self._node_ref is not None:
            self.detach_node()
        self._node_ref = weakref.ref(node)
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        parameter = node.get_parameter(USE_SIM_TIME_NAME)
        if parameter.type_ == Parameter.Type.BOOL:
            self.ros_time_is_active = parameter.value
        elif parameter.type_ != Parameter.Type.NOT_SET:
            node.get_logger().error(
                f"Invalid type for parameter '{USE_SIM_TIME_NAME}' {parameter.type_!r} "
                "should be bool"
            )
        node.add_on_set_parameters_callback(self._on_parameters)

    def detach_node(self) -> None:
        """Follow the node no more.

        :raises RuntimeError: if the node is gone while we are subscribed through it.
        """
        if self._clock_sub is not None:
            node = self._node()
            if node is None:
                raise RuntimeError("Unable to destroy previously created clock subscription")
            node.destroy_subscription(self._clock_sub)
        self._clock_sub = None
        self._node_ref = None

    def attach_clock(self, clock: ROSClock) -> None:
        """Set a clock too.

        :raises ValueError: if it is not one of ROS time.
        """
        if not isinstance(clock, ROSClock):
            raise ValueError("Only clocks with type ROS_TIME can be attached.")
        clock.set_ros_time_override(Time(nanoseconds=self._last, clock_type=ClockType.ROS_TIME))
        clock._set_ros_time_is_active(self._active)
        self._clocks.append(clock)

    def clock_callback(self, msg: Any) -> None:
        """Set the clocks by a message of ``/clock``."""
        stamp = msg.clock
        self._last = stamp.sec * 1_000_000_000 + stamp.nanosec
        for clock in self._clocks:
            clock._set_override(self._last)

    def _on_parameters(self, parameters: list[Parameter]) -> Any:
        for parameter in parameters:
            if parameter.name != USE_SIM_TIME_NAME:
                continue
            if parameter.type_ == Parameter.Type.BOOL:
                self.ros_time_is_active = parameter.value
                break
            reason = f"{USE_SIM_TIME_NAME} parameter set to something besides a bool"
            node = self._node()
            if node is not None:
                node.get_logger().error(reason)
            return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)
