"""An executor for genuine rclpy that takes messages from their subscriptions itself.

rclpy's own executors gather every entity of every node before each callback, make a wait set of
them and wrap the callback in a task: that costs more than the message's whole way. Here messages
are taken straight from the subscriptions, timers are called when they are due, and the wait set of
the subscriptions is made once. Services, clients and events go through rclpy's executor, which is
asked only when one of them has something, or now and then.

For that it needs parts of rclpy that are not its public interface. An rclpy that has others gets
its own executor, and a warning that says what was missing.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf
from typing import Any

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.task import Future

AT_ONCE = 16  # messages of one subscription, before the others have their turn
LOOK_S = 0.02  # how often timers and services are looked at, at least
EVENTS_S = 5.0  # how often quality-of-service events are, which nobody waits for
EVENTS_BEFORE_S = 1.0  # the same until the first message has come: they tell why none does


def make_executor(*nodes: Any) -> Executor:
    """The quickest executor there is for these nodes, which it then has.

    rclpy_cyclone's own takes messages directly already.
    """
    executor = SingleThreadedExecutor() if takes_directly() else DirectExecutor()
    for node in nodes:
        executor.add_node(node)
    lacking = executor.lacking() if isinstance(executor, DirectExecutor) else None
    if lacking is None:
        return executor
    nodes[0].get_logger().warning(
        f"this rclpy lets no messages be taken directly ({lacking}): its own executor spins the "
        "nodes, at a lower rate"
    )
    for node in nodes:
        executor.remove_node(node)
    executor.shutdown()
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    return executor


def takes_directly() -> bool:
    """Whether rclpy's own executor takes messages straight from the subscriptions."""
    return "rclpy_cyclone" in (rclpy.__file__ or "")


class _Inbox:
    """One subscription: `serve` hands over the messages that have come."""

    def __init__(self, subscription: Any) -> None:
        self.handle = subscription.handle
        self._take = subscription.handle.take_message
        self._type, self._raw = subscription.msg_type, subscription.raw
        self._subscription = subscription

    def try_out(self) -> None:
        """Raise if a message could not be taken or handed over."""
        if not (callable(self._take) and callable(self._subscription.callback)):
            raise TypeError("take_message or callback cannot be called")

    def serve(self, changed: Callable[[], bool]) -> bool:
        """Whether there was a message. After one that changed subscriptions none is taken."""
        for count in range(AT_ONCE):
            taken = self._take(self._type, self._raw)
            if taken is None:
                return count > 0
            self._subscription.callback(taken[0])
            if changed():
                break
        return True


class DirectExecutor(SingleThreadedExecutor):
    """Spins nodes whose subscriptions have callbacks that take the message alone.

    A node with an attribute `batch_s` above 0 gets its messages so far apart, s; one with
    `takes_when_due` before its `on_due` is called, at `due_s` on the monotonic clock. For all
    others messages are waited for.
    """

    def __init__(self) -> None:
        super().__init__()
        self._known: list[Any] = []  # subscriptions that are taken from
        self._changed = False
        self._waited: list[_Inbox] = []
        self._batched: list[_Inbox] = []
        self._paced: list[Any] = []
        self._batch_s = LOOK_S
        self._wait_set: Any = None
        self._next_rest = self._next_events = 0.0
        self._heard = False

    def lacking(self) -> str | None:
        """What this rclpy refuses of all that spinning needs; None if it has all.

        Everything is tried once on the nodes' own entities; no message is taken.
        """
        try:
            nodes = self.get_nodes()
            self._gather(nodes)
            for inbox in (*self._waited, *self._batched):
                inbox.try_out()
            self._wait(0)
            self._something_else(nodes)
            for timer in [timer for node in nodes for timer in node.timers]:
                with timer.handle:
                    _call_of(timer.handle)
                timer.is_ready(), timer.is_canceled(), timer.time_until_next_call()
        except Exception as error:  # whatever another version makes of it
            return f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"
        return None

    def wake(self) -> None:
        """rclpy calls this when a node has got an entity or lost one."""
        self._changed = True
        super().wake()

    def _has_changed(self) -> bool:
        return self._changed

    def can_execute(self, entity: Any) -> bool:
        """Whether rclpy's part is to run the entity: not what is taken here."""
        return not self._taken_here(entity) and super().can_execute(entity)

    @staticmethod
    def _taken_here(entity: Any) -> bool:
        return hasattr(entity, "msg_type") or hasattr(entity, "timer_period_ns")

    def spin(self) -> None:
        """Run callbacks until the context is shut down."""
        self.spin_until_future_complete(Future())

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until the future is done, the context is shut down, or time is over."""
        now = time.monotonic()
        end = now + timeout_sec if timeout_sec is not None and timeout_sec >= 0.0 else inf
        next_batch = next_look = now
        ok, done = self.context.ok, future.done
        while ok() and not done():
            if self._changed:
                self._follow(self.get_nodes())
            served = self._serve(self._waited)
            now = time.monotonic()
            due = min([node.due_s for node in self._paced], default=inf)
            if now >= min(due, next_batch, next_look):
                served |= self._serve(self._batched)
                next_batch = now + self._batch_s
            if now >= due:
                for node in self._paced:
                    if now >= node.due_s:
                        node.on_due()
            if now >= next_look:
                next_look = min(self._look(now), now + LOOK_S)
            self._heard |= served
            if now >= end:
                return
            if not served:
                due = min([node.due_s for node in self._paced], default=inf)
                self._sleep(min(next_look, next_batch, due, end) - time.monotonic())

    def _serve(self, inboxes: list[_Inbox]) -> bool:
        """Hand over what has come; whether anything had.

        A subscription that a callback has destroyed must not be asked again.
        """
        served = False
        for inbox in inboxes:
            if self._changed:
                break
            served |= inbox.serve(self._has_changed)
        return served

    def _follow(self, nodes: list[Any]) -> None:
        """Take from the subscriptions that there are now."""
        self._changed = False
        if [one for node in nodes for one in node.subscriptions] != self._known:
            self._gather(nodes)

    def _sleep(self, seconds: float) -> None:
        """Until a message that is waited for has come, at most so long."""
        if seconds <= 0.0 or self._changed:
            return
        if self._waited:
            self._wait(int(seconds * 1e9))
        else:
            time.sleep(seconds)

    def _wait(self, nanoseconds: int) -> None:
        """Until a message that is waited for has come, at most so long; not at all if none is."""
        if not self._waited:
            return
        self._wait_set.clear_entities()
        for inbox in self._waited:
            self._wait_set.add_subscription(inbox.handle)
        self._wait_set.wait(nanoseconds)

    def _look(self, now: float) -> float:
        """Call timers that are due and serve the rest; when the next timer is due, s."""
        nodes = self.get_nodes()
        nearest_ns = LOOK_S * 1e9
        for timer in [timer for node in nodes for timer in node.timers]:
            if timer.is_ready():
                with timer.handle:
                    _call_of(timer.handle)()
                timer.callback()
            if not timer.is_canceled():
                nearest_ns = min(nearest_ns, timer.time_until_next_call())
        if now >= self._next_rest:
            self._next_rest = now + LOOK_S
            self._look_at_rest(nodes, now)
        return time.monotonic() + max(0.0, nearest_ns * 1e-9)

    def _look_at_rest(self, nodes: list[Any], now: float) -> None:
        """New subscriptions, services, clients and, now and then, events."""
        self._follow(nodes)
        if self._something_else(nodes):
            self.spin_once(timeout_sec=0.0)
        elif now >= self._next_events:
            self._next_events = now + (EVENTS_S if self._heard else EVENTS_BEFORE_S)
            self.spin_once(timeout_sec=0.0)

    def _gather(self, nodes: list[Any]) -> None:
        """Sort the subscriptions there are now, and make the wait set of those waited for."""
        self._waited, self._batched = [], []
        self._paced = [node for node in nodes if getattr(node, "takes_when_due", False)]
        batches = [LOOK_S]
        self._known = [one for node in nodes for one in node.subscriptions]
        self._changed = False
        for node in nodes:
            batch_s = getattr(node, "batch_s", 0.0)
            later = batch_s > 0.0 or getattr(node, "takes_when_due", False)
            if batch_s > 0.0:
                batches.append(batch_s)
            for subscription in node.subscriptions:
                (self._batched if later else self._waited).append(_Inbox(subscription))
        self._batch_s = min(batches)
        self._wait_set = _wait_set(self.context, subscriptions=len(self._waited))

    def _something_else(self, nodes: list[Any]) -> bool:
        """Whether a service has a request or a client its response."""
        services = [service for node in nodes for service in node.services]
        clients = [client for node in nodes for client in node.clients]
        if not services and not clients:
            return False
        found = _wait_set(self.context, clients=len(clients), services=len(services))
        found.clear_entities()
        for service in services:
            found.add_service(service.handle)
        for client in clients:
            found.add_client(client.handle)
        found.wait(0)
        return bool(found.get_ready_entities("service") or found.get_ready_entities("client"))


def _call_of(handle: Any) -> Callable[[], Any]:
    """What tells rcl that a timer has been called, whichever way this rclpy has."""
    call: Callable[[], Any] = getattr(handle, "call_timer_with_info", None) or handle.call_timer
    return call


def _wait_set(context: Any, subscriptions: int = 0, clients: int = 0, services: int = 0) -> Any:
    from rclpy.impl.implementation_singleton import rclpy_implementation

    none = 0
    return rclpy_implementation.WaitSet(
        subscriptions, none, none, clients, services, none, context.handle
    )
