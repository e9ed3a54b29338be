"""Guard conditions: callbacks that any thread can ask for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy._ready import Ready
from rclpy.exceptions import InvalidHandle
from rclpy.utilities import get_default_context


class GuardCondition(Ready):
    """Has its callback run by the executor each time it is triggered.

    :param callback: function without arguments.
    :param callback_group: the callback's group.
    :param context: the context, by default the default one.
    """

    def __init__(
        self,
        callback: Callable[[], Any] | None,
        callback_group: Any,
        context: Any = None,
    ) -> None:
        super().__init__()
        self._context = get_default_context() if context is None else context
        self.callback = callback
        self.callback_group = callback_group
        self._triggered = False

    def trigger(self) -> None:
        """Ask for the callback; asking again before it has run changes nothing.

        :raises InvalidHandle: if the condition was destroyed.
        """
        if self._destroyed:
            raise InvalidHandle("cannot trigger: the guard condition was destroyed")
        self._triggered = True
        self._ready()

    def _pending(self) -> bool:
        return self._triggered

    def _take(self) -> tuple[Any, tuple[Any, ...]] | None:
        if not self._triggered:
            return None
        self._triggered = False
        return (self.callback, ()) if self.callback else None
