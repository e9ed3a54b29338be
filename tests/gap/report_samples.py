"""Diagnoses made by hand, one of each verdict, with series that fit their figures."""

from __future__ import annotations

import numpy as np

from ecyl_ros.gap.diagnosis import (
    Candidate,
    Cause,
    ConditionShare,
    Diagnosis,
    FittedParameter,
    PortCheck,
    Series,
    SignalGap,
)

RATE_HZ = 1000.0
SAMPLES = 6000
NAMES = (("rotor_velocity", "rad/s", 2e-3), ("current_q", "A", 5e-3), ("rod_position", "m", 5e-7))


def coulomb(confidence: float = 0.97, alternatives: tuple[str, ...] = ()) -> Cause:
    """Coulomb friction of 0.38 N m."""
    return Cause(
        effect="rotor_coulomb_friction",
        block="motor_mechanical",
        title="Coulomb friction on the rotor",
        confidence=confidence,
        parameters=(FittedParameter("coulomb_nm", "N m", 0.38024, 0.3790, 0.3814),),
        shrink=0.7,
        shrink_alone_lost=0.71,
        alternatives=alternatives,
        excitation="passages through the clearance",
    )


def backlash() -> Cause:
    """A clearance of 9.65 mrad."""
    return Cause(
        effect="backlash_error",
        block="transmission",
        title="wrong backlash",
        confidence=0.91,
        parameters=(FittedParameter("backlash_rad", "rad", 9.652e-3, 9.64e-3, 9.66e-3),),
        shrink=0.29,
        shrink_alone_lost=0.3,
    )


VALUES = {
    "rotor_coulomb_friction": {
        "coulomb_nm": 0.38023636,
        "breakaway_rad": 1.25e-5,
        "bristle_damping_s": 2e-4,
    },
    "backlash_error": {"backlash_rad": 9.65225643915881e-3},
}


def diagnosis(
    verdict: str = "explained",
    causes: tuple[Cause, ...] = (),
    *,
    before: float = 10.0,
    after: float = 1.0,
    source: str = "rec/one.mcap",
    drive: str = "drives/nominal.yaml",
    notes: tuple[str, ...] = (),
) -> Diagnosis:
    """before, after: the gap as multiples of the noise floor."""
    random = np.random.default_rng(4)
    time = np.arange(SAMPLES) / RATE_HZ
    motion = np.sin(2.0 * np.pi * 1.5 * time)
    # The third held-out stretch has four times the gap of the others.
    held = (time / 0.5).astype(int) % 3 == 1
    size = np.where((time >= 3.5) & (time < 4.0), 4.0, 1.0)
    recorded, simulated, improved, signals = [], [], [], []
    for row, (name, unit, floor) in enumerate(NAMES):
        clean = motion * floor * 500.0 * (row + 1)
        recorded.append(clean + random.normal(0.0, floor, SAMPLES))
        simulated.append(clean - before * floor * size * np.sign(np.cos(2.0 * np.pi * 1.5 * time)))
        improved.append(clean - max(after - 1.0, 0.0) * floor)
        final = after if causes else before
        signals.append(SignalGap(name, unit, before * floor, final * floor, floor))
    levels = np.linspace(before, after, len(causes) + 1)[1:] * 0.004
    return Diagnosis(
        source=source,
        drive=drive,
        verdict=verdict,
        block=None if verdict == "no_gap" else "motor_mechanical",
        signals=tuple(signals),
        when=(
            ()
            if verdict == "no_gap"
            else (ConditionShare("reversal", 0.74, 0.2), ConditionShare("rest", 0.1, 0.25))
        ),
        frequency_hz=() if verdict == "no_gap" else (1.5, 4.5),
        ports=(PortCheck("motor_mechanical", "torque balance in contact", "N m", 0.36, 9e-4),),
        causes=causes,
        before=before * 0.004,
        after=(after if causes else before) * 0.004,
        floor=0.004,
        shrink=(before - after) / (before - 1.0) if causes else 0.0,
        steps=tuple(float(one) for one in levels),
        candidates=(
            ()
            if verdict == "no_gap"
            else (
                Candidate(("rotor_coulomb_friction",), 0.9, 0.93),
                Candidate(("stribeck_friction",), 1.2, 1.31),
                Candidate((), 6.4, 6.5),
            )
        ),
        notes=notes,
        values={one.effect: dict(VALUES[one.effect]) for one in causes},
        series=Series(
            time,
            0.01 * motion,
            np.array(recorded),
            np.array(simulated),
            np.array(improved if causes else simulated),
            held,
            np.ones(SAMPLES, dtype=bool),
        ),
        seconds=12.3,
        replays=321,
        misfit_before=6.5,
        misfit_after=0.93 if causes else 6.5,
        duration_s=float(time[-1]),
        rate_hz=RATE_HZ,
    )


def of_each_verdict() -> dict[str, Diagnosis]:
    """One diagnosis a verdict."""
    return {
        "no_gap": diagnosis("no_gap", before=1.0),
        "explained": diagnosis("explained", (coulomb(),)),
        "partly_explained": diagnosis(
            "partly_explained", (coulomb(), backlash()), after=3.0, notes=("no rod scale",)
        ),
        "unexplained": diagnosis("unexplained", notes=("closest: local jam",)),
    }
