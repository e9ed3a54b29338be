"""What one frequency cannot tell: an inertia from two masses and a stiffness between them."""

from __future__ import annotations

import numpy as np
import pytest
from rigid_machines import LINEAR, RATE_HZ, Motion, causes, recorded

from ecyl_ros.gap.diagnose import diagnose


def _swing(*hertz: float) -> Motion:
    """Equal accelerations at each frequency."""
    time = np.arange(int(12.0 * RATE_HZ)) / RATE_HZ
    rates = 2.0 * np.pi * np.array(hertz)[:, None]
    phase = rates * time + 0.3
    size = 2.0 / rates**2
    return Motion(
        time,
        (size * np.sin(phase)).sum(0),
        (size * rates * np.cos(phase)).sum(0),
        (-size * rates**2 * np.sin(phase)).sum(0),
    )


@pytest.mark.parametrize(
    ("hertz", "alike"), [((4.0,), True), ((1.0, 4.0), False), ((0.25,), False)]
)
def test_an_inertia_at_one_frequency_may_be_a_resonance(
    hertz: tuple[float, ...], alike: bool
) -> None:
    """14 kg for 20: named with its value, beside a wrong stiffness where one frequency told it
    that may be one of a resonance."""
    motion = _swing(*hertz)
    found = causes(diagnose(recorded(motion, 14.0 * motion.a, LINEAR, 0.3, 1e-6), LINEAR))
    (name,) = found
    assert name == "load_inertia_error"
    assert found[name].parameters[0].value == pytest.approx(14.0, rel=0.02)
    assert found[name].alternatives == (("stiffness_error",) if alike else ())
    assert (found[name].confidence >= 0.9) == (not alike)
