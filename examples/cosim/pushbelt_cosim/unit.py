"""Base class of the units: variables by name."""

from __future__ import annotations

from abc import abstractmethod
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

INPUT, OUTPUT, PARAMETER = Fmi2Causality.input, Fmi2Causality.output, Fmi2Causality.parameter

MAP_FILE = "maps.npz"
"""File name of the map in the resources of the control unit's FMU."""


class Unit(Fmi2Slave):
    """A unit that stores its variables in `values` by name: numbers in SI units, or Booleans."""

    author = "The pushbelt developers"

    def __init__(self, **keywords: object) -> None:
        super().__init__(**keywords)
        self.values: dict[str, float | bool] = {}

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advances by a communication step."""
        # libcosim computes its steps as differences of times. Rounding makes them equal in all importers.
        self.advance(current_time, round(step_size, 9))
        return True

    @abstractmethod
    def advance(self, time: float, step: float) -> None:
        """Advances from a time by a step, s."""

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """The model description. pythonfmu omits the initial unknowns, which importers require."""
        root = super().to_xml(model_options or {})
        structure = root.find("ModelStructure")
        unknowns = SubElement(structure, "InitialUnknowns")
        for output in structure.iterfind("Outputs/Unknown"):
            SubElement(unknowns, "Unknown", index=output.get("index"))
        return root

    def declare(self, causality: Fmi2Causality, variables: dict[str, tuple[float | bool, str]]) -> None:
        """Declares variables: name, start value, description."""
        for name, (start, description) in variables.items():
            self.values[name] = start
            kind = Boolean if isinstance(start, bool) else Real
            self.register_variable(
                kind(
                    name,
                    causality=causality,
                    variability=_variability(causality, kind),
                    description=description,
                    getter=lambda name=name: self.values[name],
                    setter=lambda value, name=name: self.values.__setitem__(name, value),
                ),
                nested=False,
            )


def _variability(causality: Fmi2Causality, kind: type) -> Fmi2Variability:
    if causality == PARAMETER:
        return Fmi2Variability.fixed
    return Fmi2Variability.discrete if kind is Boolean else Fmi2Variability.continuous
