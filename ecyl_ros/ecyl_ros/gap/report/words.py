"""Names of the code in words of a drive engineer."""

from __future__ import annotations

from collections.abc import Sequence

from ...effects.catalogue import CATALOGUE
from ..listed import listed

_BLOCKS = {
    "motor_electrical": "the motor's electrical side",
    "motor_mechanical": "the rotor",
    "transmission": "the transmission",
    "load": "the load",
    "sensor": "a sensor",
    "timing": "the timing of the loop",
    "controller": "the controller",
}
_SIGNALS = {"current_q": "current i_q", "voltage_q": "voltage u_q"}
_CONDITIONS = {
    "reversal": "at reversals",
    "rest": "at rest",
    "low_speed": "at low speed",
    "high_speed": "at high speed",
    "acceleration": "under strong acceleration",
    "high_torque": "at high torque",
    "position": "within one tenth of the stroke",
    "time": "within one tenth of the time",
    "forwards": "on the way forwards",
    "backwards": "on the way backwards",
}
_VERDICTS = {
    "no_gap": "No gap",
    "within_sheet": "Within the data sheet",
    "explained": "Explained",
    "partly_explained": "Partly explained",
    "described": "Described",
    "unexplained": "Unexplained",
    "not_judgeable": "Not judgeable",
}
MOST_NOTES = 5  # that a terminal or a notebook shows; report and JSON have all
# Below the sheet's table, where nothing closes the gap.
MOVED_BY_GAP = (
    "The unexplained gap may have moved these values: their intervals do not allow for it."
)
RAN_AWAY = "runs away"  # of a replay whose error says nothing of the drive (NaN)
_NAMES = ("Coulomb", "Stribeck")  # words that keep their capital
_MASS_NOUNS = ("friction", "cogging", "ripple", "dead time", "eccentricity", "gravity")


def block(name: str | None) -> str:
    """A block with its article."""
    return "no block" if name is None else _BLOCKS.get(name, name.replace("_", " "))


def signal(name: str) -> str:
    """A signal without article."""
    return _SIGNALS.get(name, name.replace("_", " "))


def condition(name: str) -> str:
    """When, as an adverb."""
    if name.startswith("mode_"):
        return f"in mode {name.removeprefix('mode_')}"
    return _CONDITIONS.get(name, name.replace("_", " "))


def constant(key: str) -> str:
    """A constant of the drive file by its dotted key: "load.inertia" is "load inertia"."""
    group, _, name = key.partition(".")
    text = name.replace(".", " ").replace("_", " ")
    text = text.replace("back emf", "back-EMF")
    if group == "load" and name != "constant_load":
        return f"load {text}"
    if group == "motor" and name in ("viscous_friction", "inductance", "resistance"):
        return f"motor {text}"
    return text


def verdict(name: str) -> str:
    """The verdict as a heading."""
    return _VERDICTS.get(name, name.replace("_", " "))


def title(effect: str) -> str:
    """An effect's title as it stands within a sentence."""
    known = CATALOGUE.get(effect)
    text = known.title if known is not None else effect.replace("_", " ")
    return text if text.startswith(_NAMES) else text[:1].lower() + text[1:]


def heading(effect: str) -> str:
    """An effect's title with a capital."""
    text = title(effect)
    return text[:1].upper() + text[1:]


def with_article(effect: str) -> str:
    """An effect's title with "a" or "an" where it can be counted."""
    text = title(effect)
    if any(word in text for word in _MASS_NOUNS):
        return text
    return f"{'an' if text[0] in 'aeiou' else 'a'} {text}"


def effect_set(effects: Sequence[str]) -> str:
    """The titles of a set of effects; the empty set is the nominal model."""
    return listed([title(one) for one in effects]) if effects else "nominal model, nothing added"
