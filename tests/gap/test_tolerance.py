"""A nominal constant off by less than its tolerance is a trace, not a cause, beside a cause."""

from __future__ import annotations

import pytest
from sheets import exact

from ecyl_ros.gap.judge.tolerance import traces

DELAY = {"actuation_delay": {"delay_s": 1.4e-4}}


def stiffness(factor: float) -> dict[str, dict[str, float]]:
    """The bench drive's, times `factor`."""
    nominal = exact("bench").transmission.stiffness[0]
    return {"stiffness_error": {"stiffness_nm_per_rad": factor * nominal}}


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ({**DELAY, **stiffness(0.996)}, ["stiffness_error"]),
        ({**DELAY, **stiffness(1.009)}, ["stiffness_error"]),
        ({**DELAY, **stiffness(0.95)}, []),
        ({**DELAY, **stiffness(1.02)}, []),
        (stiffness(0.996), []),
        (DELAY, []),
        ({**DELAY, "lead_error": {"lead_m": 1.003 * 0.02}}, []),
    ],
    ids=["below", "above", "clearly less", "clearly more", "alone", "no constant", "lead"],
)
def test_less_than_a_hundredth_of_a_constant_is_a_trace(values, found) -> None:
    """Beside another cause only; and never of the screw's lead, which is made far more exactly."""
    assert traces(values, exact("bench")) == found
