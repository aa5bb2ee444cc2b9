"""Parameters of a pushbelt from its dimensions. SI units; `docs/belt.md` has the sources of the formulas.

Engineering values are those with which the formulas give the published variators `bench168` and `belt155`, both with elements that are
24 mm wide and 1.5 mm thick. A test checks that.
"""

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cached_property
from typing import Any, NamedTuple

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import BELT_LENGTH
from pushbelt.fmu.geometry import TwoPulleyCurve
from pushbelt.maps.plan import stops

SETS = 2  # Ring sets of a belt
WIDTH = 0.024  # Width of the elements to which the engineering values of stiffness and film apply, m
THICKNESS = 0.0015  # Thickness of the elements to which the engineering values of the film apply, m
PILLAR = 0.006  # Width of an element that its two ring slots leave to the pillar and the margins, m
HEIGHT = 0.012  # Height of an element, m
FILL = 0.59  # Share of width × height that an element covers: 24 mm × 12 mm × 1.5 mm then weighs 2.0 g
ELEMENT_DENSITY = 7800.0  # Density of the elements' steel, kg/m³
ROCKING_EDGE = 0.001  # Distance of an element's centre of mass from its rocking edge, m
SADDLE = 0.00017  # Height of the saddle, on which the ring rests, above the rocking edge, m
PLAY = 0.0002  # End play of the unstretched ring, m
MOST_PLAY = 0.003  # Largest plausible end play, m
STEEL = 2.06e11  # Young's modulus of the elements, Pa
FLANK = 0.007  # Height of an element's flank, m
PUSH_STIFFNESS = 1e7  # Push stiffness of elements of `WIDTH`, N
FILM = {"belt.filmDamping": 2.7, "belt.squeezeDamping": 75.0, "belt.suction": 19.0}
"""Film parameters of elements of `WIDTH` and `THICKNESS`, SI."""
CLEARANCE = 0.004  # Distance of the two pulleys at the largest radii, m
MIN_RADIUS = 0.03  # Smallest pitch radius, m


def _require(true: bool, text: str) -> None:
    if not true:
        raise ArgumentError(text)


def _of(name: str, low: float, high: float, option: str, default: Any = MISSING, shown: str = "") -> Any:
    """A dimension with its range in SI, outside of which it is most likely in another unit. `option` is the unit of its option, in which
    `shown` gives the default."""
    unit = {"MM": "m", "M": "m", "N": "", "G": "kg", "GPA": "Pa", "KG/M3": "kg/m3", "DEG": "rad"}[option]
    text = f"{name} [default: {shown}]" if shown else name
    about = {"name": "the " + name.split(":")[0], "low": low, "high": high, "unit": unit, "option": option, "help": text}
    return field(default=default, metadata=about)


@dataclass(frozen=True)
class Dimensions:
    """Dimensions of a belt, SI. Those with the default None follow from the others.

    Width, length and pitch offset are those at the pitch line, of the unstretched centre line of the ring, and of this line from the
    rocking edge. The end play is the length of the pitch line less that of the stacked elements.
    """

    width: float = _of("width of the elements", 0.01, 0.1, "MM")
    layers: int = _of("number of layers of each ring set", 1, 30, "N")
    length: float = _of("length of the belt: of the unstretched ring at its centre line", *BELT_LENGTH, "M")
    center_distance: float = _of("center distance: between the pulley axes", 0.05, 2.0, "M")
    element_thickness: float | None = _of("thickness of an element", 0.0005, 0.01, "MM", None, "1.5")
    elements: int | None = _of("number of elements", 50, 5000, "N", None, "as many as fit")
    play: float | None = _of("end play", 0.0, MOST_PLAY, "MM", None, "0.2, or what number and thickness leave")
    element_mass: float | None = _of("mass of an element", 0.0001, 0.05, "G", None, "from its size")
    element_height: float = _of("height of an element", 0.004, 0.04, "MM", HEIGHT, "12")
    layer_thickness: float = _of("thickness of a layer", 0.00005, 0.001, "MM", 0.000185, "0.185")
    layer_width: float | None = _of("width of a layer", 0.001, 0.05, "MM", None, "(width − 6)/2")
    pitch_offset: float | None = _of("pitch offset: rocking edge to ring centre line", 0.0, 0.01, "MM", None, "0.17 and half the layers")
    young: float = _of("Young's modulus of the ring", 1e11, 3e11, "GPA", 1.86e11, "186")
    density: float = _of("density of the ring", 6000.0, 10000.0, "KG/M3", 8000.0, "8000")
    wedge_angle: float = _of("half wedge angle", 0.08, 0.35, "DEG", math.radians(11.0), "11")
    min_radius: float = _of("smallest pitch radius", 0.01, 0.5, "M", MIN_RADIUS, "30mm")
    max_radius: float | None = _of("largest pitch radius", 0.02, 1.0, "M", None, "pulleys 4 mm apart")

    def __post_init__(self) -> None:
        for one in fields(self):
            value, of = getattr(self, one.name), one.metadata
            if value is not None and not of["low"] <= value <= of["high"]:
                raise ArgumentError(f"{of['name']} is {value:g} {of['unit']}".rstrip() + f", not within {of['low']:g} to {of['high']:g}")
        least = 2.0 * self.center_distance
        text = f"a belt of {self.length:g} m does not close around axes {self.center_distance:g} m apart: it must be longer than {least:g} m"
        _require(self.length > least, text)


class Entry(NamedTuple):
    """A parameter with its origin: `given`, `geometry` (follows from given dimensions) or `typical` (contains an engineering value)."""

    value: float
    origin: str = "given"
    note: str = ""


def _chosen(value: float, given: bool, note: str = "") -> Entry:
    """A value that is given, or an engineering value."""
    return Entry(value) if given else Entry(value, "typical", note)


class Belt:
    def __init__(self, dimensions: Dimensions) -> None:
        """Raises ArgumentError if the numbers of the elements do not fit each other, or no ratio is within the stops."""
        self.dimensions = d = dimensions
        self.layer_width = d.layer_width or (d.width - PILLAR) / SETS
        # From the rocking edge to the ring's centre line.
        self.pitch_offset = SADDLE + 0.5 * d.layers * d.layer_thickness if d.pitch_offset is None else d.pitch_offset
        self.pitch_length = d.length - 2.0 * math.pi * self.pitch_offset
        _require(self.pitch_length > 0.0, "the pitch offset is too large for this belt")
        stacked = self.pitch_length - (PLAY if d.play is None else d.play)
        self.elements = d.elements or round(stacked / (d.element_thickness or THICKNESS))
        fixed = d.element_thickness if d.elements and d.play is None else None
        self.element_thickness = fixed or stacked / self.elements
        self.play = self.pitch_length - self.elements * self.element_thickness
        self.element_mass = d.element_mass or ELEMENT_DENSITY * FILL * d.width * d.element_height * self.element_thickness
        self.max_radius = d.max_radius or 0.5 * (d.center_distance - CLEARANCE)
        self._check()

    def _check(self) -> None:
        d = self.dimensions
        low, high = 1e3 * d.min_radius, 1e3 * self.max_radius
        stacked, line = f"{self.elements} elements of {1e3 * self.element_thickness:.4g} mm", f"{1e3 * self.pitch_length:.2f} mm"
        text = f"{stacked} on a pitch line of {line} leave an end play of {1e3 * self.play:.2f} mm, not within 0 to {1e3 * MOST_PLAY:g} mm"
        _require(0.0 <= self.play <= MOST_PLAY, f"{text}: specify two of number, thickness and play")
        text = f"two layers of {1e3 * self.layer_width:g} mm are not narrower than the elements, {1e3 * d.width:g} mm"
        _require(SETS * self.layer_width < d.width, text)
        _require(low < high, f"the smallest pitch radius, {low:g} mm, is not below the largest, {high:g} mm")
        text = f"pulleys with a pitch radius of {high:g} mm touch each other at a center distance of {1e3 * d.center_distance:g} mm"
        _require(2.0 * self.max_radius < d.center_distance, text)
        one = 1e3 * (TwoPulleyCurve(d.center_distance, d.length, 0.0).primary_radius - self.pitch_offset)
        text = f"at ratio 1 the pitch radius is {one:.1f} mm, not within the stops at {low:g} and {high:g} mm: no ratio can be reached"
        _require(low <= one <= high, text)

    @cached_property
    def reach(self) -> float:
        """Largest ratio between the stops; the smallest is its reciprocal, as both pulleys are alike."""
        return stops({name: entry.value for name, entry in self.entries.items()})[1]

    @cached_property
    def entries(self) -> dict[str, Entry]:
        """Parameters that follow from the dimensions, by FMU name."""
        d = self.dimensions
        apart = "engineering value: the pulleys are 4 mm apart at this radius"
        stops = {
            "minRadius": _chosen(d.min_radius, d.min_radius != MIN_RADIUS, "engineering value"),
            "maxRadius": _chosen(self.max_radius, d.max_radius is not None, apart),
        }
        return {
            "geometry.centerDistance": Entry(d.center_distance), "geometry.beltLength": Entry(d.length),
            "geometry.wedgeAngle": _chosen(d.wedge_angle, d.wedge_angle != Dimensions.wedge_angle, "11 degrees, as usual"),
            **{f"{pulley}.{name}": stop for pulley in ("primary", "secondary") for name, stop in stops.items()},
            **self._ring(), **self._elements(),
        }  # fmt: skip

    def _ring(self) -> dict[str, Entry]:
        d = self.dimensions
        area = SETS * d.layers * self.layer_width * d.layer_thickness
        stiffness = d.young * area
        width = _chosen(self.layer_width, d.layer_width is not None, "(width - 6 mm)/2")
        origin = "geometry" if d.layer_width is not None else "typical"
        layers = f"2 sets of {d.layers} layers, {1e3 * d.layer_thickness:g} mm x {1e3 * self.layer_width:g} mm"
        bends, lateral = (stiffness * size**2 / 12.0 for size in (d.layer_thickness, self.layer_width))
        aged = "a circle of the belt's length, as which a layer was aged and nitrided"
        return {
            "ring.layers": Entry(d.layers),
            "ring.layerThickness": _chosen(d.layer_thickness, d.layer_thickness != Dimensions.layer_thickness),
            "ring.layerWidth": width,
            "ring.massPerLength": Entry(d.density * area, origin, f"{layers}, {d.density:g} kg/m3"),
            "ring.axialStiffness": Entry(stiffness, origin, f"{layers}, {1e-9 * d.young:g} GPa"),
            "ring.bendingStiffness": Entry(bends, origin, "the same layers, each bends separately"),
            "ring.lateralBendingStiffness": Entry(lateral, origin, "the same layers, each set bends separately"),
            "ring.residualCurvature": Entry(2.0 * math.pi / d.length, "typical", aged),
        }

    def _elements(self) -> dict[str, Entry]:
        d = self.dimensions
        mass, thickness, weighed = self.element_mass, self.element_thickness, d.element_mass is not None
        number = f"{self.elements} elements of {1e3 * mass:.4g} g on the pitch line"
        filled = f"{number}, each 59 % of width x {1e3 * d.element_height:g} mm x thickness, 7800 kg/m3"
        wider, thicker = d.width / WIDTH, thickness / THICKNESS
        saddle = "saddle 0.17 mm above the rocking edge, and half the layers"
        play = "given" if d.play is not None else "geometry" if d.elements and d.element_thickness else "typical"
        inertia = 0.5 * mass * (d.element_height**2 / 12.0 + ROCKING_EDGE**2)
        bar = f"half of a bar of {1e3 * mass:.4g} g and {1e3 * d.element_height:g} mm, its centre 1 mm from the rocking edge"
        per_length = self.elements * mass / self.pitch_length
        flank = STEEL * FLANK / (0.5 * d.width)
        return {
            "belt.pitchOffset": _chosen(self.pitch_offset, d.pitch_offset is not None, saddle),
            "belt.play": Entry(self.play, play, "of the unstretched ring"),
            "belt.elementThickness": Entry(thickness, "geometry" if d.elements or d.element_thickness else "typical", "mean"),
            "belt.massPerLength": Entry(per_length, "geometry", number) if weighed else Entry(per_length, "typical", filled),
            "belt.elementInertia": Entry(inertia, "typical", bar),
            "belt.pushStiffness": Entry(PUSH_STIFFNESS * wider, "typical", "in proportion to the width: 1e7 N at 24 mm"),
            **{
                name: Entry(value * scale, "typical", f"in proportion to the faces: {value:g} at 24 mm x 1.5 mm")
                for (name, value), scale in zip(FILM.items(), (wider, wider * thicker, wider), strict=True)
            },
            "contact.stiffness": Entry(flank, "typical", "half an element in compression, flank of 7 mm"),
        }

    def document(self, name: str, base: str, values: Mapping[str, float], changes: Mapping[str, float]) -> dict[str, Any]:
        """The parameter set. `values` are the parameters of the set `base`, used where nothing follows from the dimensions.
        `changes` are values of the user. They come first."""
        taken = {key: Entry(value, "typical", f"as {base}") for key, value in values.items()}
        entries = {**taken, **self.entries, **{key: Entry(value) for key, value in changes.items()}}
        d = self.dimensions
        about = f"belt of {1e3 * d.width:g} mm with 2 x {d.layers} layers, {self.elements} elements, {1e3 * d.length:g} mm long"
        note = "SI units. Start values of the FMU by variable name. Given values come from the user, geometry ones follow from them; "
        return {
            "id": name, "about": f"{about}, on axes {1e3 * d.center_distance:g} mm apart",
            "note": note + "typical ones are or contain engineering values.",
            "parameters": {name: {key: part for key, part in one._asdict().items() if part != ""} for name, one in entries.items()},
        }  # fmt: skip
