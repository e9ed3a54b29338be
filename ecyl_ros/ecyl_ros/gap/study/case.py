"""What is drawn of one drive and sealed: its label, whatever kind of drive it is."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from .causes import cause_of

Values = dict[str, float]

_TUPLES = ("withheld", "unseen", "also")  # of a case's fields, lists in its label

KINDS = ("single", "pair", "none", "outside", "withheld", "beyond")
# Drawn only when asked for: of a law that has no name; one effect beside what no model knows.
LAW, STRUCTURE = "law", "structure"


@dataclass(frozen=True)
class Case:
    """One drawn drive; everything about it follows from these fields and the study's drives.

    Attributes:
        index: place in the study.
        seed: of motion, nuisances, phases and noise.
        kind: one of `KINDS`, `LAW` or `STRUCTURE`: one effect of the contract's catalogue; two;
            none; one that the diagnosis does not know; one of the catalogue withheld from it; one
            beyond the contract's catalogue that it may know; a law of one or two variables; one
            effect beside structure that no model knows.
        effects: true parameters by effect; empty for `none`.
        withheld: effects that the diagnosis is not given.
        gaps: for each effect its own gap (the others in place) in noise floors, by signal.
        drives: which drives it was drawn of: bench, random or rigid.
        sheet: relative standard deviation by which its constants were drawn off the sheet.
        constants: true values of what the sheet states, by key of the drive file, SI.
        tolerances: of these, as the diagnosis is told them.
        nominal: what the sheet holds in place of an effect's parameters: {effect: {parameter:
            value}}, where it holds anything.
        unseen: effects of the case that its recording cannot show; not naming them is no miss.
        also: what is there besides, small as it is: naming it is no error.
        facts: what else was drawn, for whoever looks at the case.
    """

    index: int
    seed: int
    kind: str
    effects: dict[str, Values] = field(default_factory=dict)
    withheld: tuple[str, ...] = ()
    gaps: dict[str, dict[str, float]] = field(default_factory=dict)
    drives: str = "bench"
    sheet: float = 0.0
    constants: Values = field(default_factory=dict)
    tolerances: dict[str, float | str] = field(default_factory=dict)
    nominal: dict[str, Values] = field(default_factory=dict)
    unseen: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)

    def label(self) -> dict[str, Any]:
        """What is sealed: plain data."""
        return asdict(self) | {name: list(getattr(self, name)) for name in _TUPLES}

    @classmethod
    def from_label(cls, label: dict[str, Any]) -> Case:
        """The case of which `label` is the label."""
        return cls(**{**label, **{name: tuple(label[name]) for name in _TUPLES}})

    @property
    def names(self) -> set[str]:
        """The case's effects as a catalogue may call them."""
        return {cause_of(self.drives, name).name for name in self.effects}

    @property
    def akin(self) -> set[str]:
        """Effects that name the same cause in another form; naming them is no error."""
        forms = {other for name in self.effects for other in cause_of(self.drives, name).akin}
        return forms | set(self.also)

    @property
    def nameable(self) -> set[str]:
        """Those of its effects that the diagnosis was given, if it knows them."""
        return {name for name in self.names - set(self.withheld) if not name.startswith("x_")}

    @property
    def blocks(self) -> set[str]:
        """Where the case's effects act."""
        return {cause_of(self.drives, name).block for name in self.effects}

    @property
    def judgeable(self) -> bool:
        """Whether the recording can show every effect of the case."""
        return not self.unseen
