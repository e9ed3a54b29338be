"""Names and units of parameters that are counted in the effort and motion of a rigid drive."""

from __future__ import annotations

from dataclasses import dataclass

_TOKENS = {"N": "n", "N m": "nm", "A": "a", "V": "v", "1": ""}
EFFORT_UNITS = tuple(_TOKENS)


def own_effort(linear: bool) -> str:
    """Unit of the output's own force or torque."""
    return "N" if linear else "N m"


@dataclass(frozen=True)
class Units:
    """Units of effort and of what multiplies position, speed and acceleration."""

    effort: str
    linear: bool

    @property
    def _token(self) -> str:
        return _TOKENS[self.effort]

    @property
    def own(self) -> bool:
        """Whether effort is counted in the output's own force or torque."""
        return self.effort == own_effort(self.linear)

    def level(self, name: str) -> str:
        """Name of a parameter that is an effort."""
        return f"{name}_{self._token}".rstrip("_")

    @property
    def load(self) -> str:
        """Name of a parameter that is a constant load."""
        return self.level("force" if self.linear else "torque")

    def per_speed(self, name: str) -> str:
        """Name of a parameter that is an effort per speed."""
        return f"{name}_{self._token}_s_per_{'m' if self.linear else 'rad'}".replace("__", "_")

    def per_position(self, name: str) -> str:
        """Name of a parameter that is an effort per position."""
        return f"{name}_{self._token}_per_{'m' if self.linear else 'rad'}".replace("__", "_")

    @property
    def end(self) -> str:
        """Unit of position."""
        return "m" if self.linear else "rad"

    @property
    def speed_unit(self) -> str:
        """Of an effort per speed."""
        return f"{self.effort} s/{self.end}"

    @property
    def inertia(self) -> tuple[str, str]:
        """Name and unit of the inertia."""
        if self.effort == "N" and self.linear:
            return "mass_kg", "kg"
        if self.effort == "N m" and not self.linear:
            return "inertia_kg_m2", "kg m^2"
        name = f"inertia_{self._token}_s2_per_{self.end}".replace("__", "_")
        return name, f"{self.effort} s^2/{self.end}"

    def gain(self, by_voltage: bool) -> tuple[str, str]:
        """Name and unit of the gain from the recorded signal to effort."""
        name = "torque_constant_n_per_a" if self.linear else "torque_constant_nm_per_a"
        unit = "N/A" if self.linear else "N m/A"
        if by_voltage:
            name, unit = name.removesuffix("a") + "v", unit.replace("A", "V")
        return name, unit
