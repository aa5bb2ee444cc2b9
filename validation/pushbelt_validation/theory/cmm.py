"""Continuum theory of a metal belt on deformable pulleys, after Carbone, Mangialardi and Mantriota.

It is an independent reference for the variator, without common code, mesh or unknowns. A one-dimensional,
inextensible belt without bending stiffness runs steadily over two pulleys whose grooves are opened by the load.

Source
------
G. Carbone, L. Mangialardi, G. Mantriota: "The Influence of Pulley Deformations on the Shifting Mechanism of
Metal Belt CVT", J. Mech. Des. 127 (2005) 103-113. Shape of the loaded groove: H. Sattler, "Efficiency of Metal
Chain and V-Belt CVT", Proc. CVT'99, Eindhoven (1999).

Symbols (SI, angles in rad)
---------------------------
theta   place on the arc, 0 where the belt enters, alpha (wrap angle) where it leaves; grows with the motion
beta    half wedge angle;  mu  coefficient of friction between flank and sheave
Delta   amplitude of the groove: half opening angle beta + (Delta/2) cos(theta - theta_c). Together with the local
        groove width it lets the belt run at R (1 - a Delta cos(theta - theta_c)), a = (1 + cos^2 beta)/sin 2beta
theta_c centre of the opening, where the belt runs deepest
F       net strand force, N. For a pushbelt F = T - Q, ring tension minus push force
sigma   belt mass per length, V belt speed; only the reduced force F' = F - sigma V^2 enters
p       normal force per flank and belt length, N/m;  S  axial force on one sheave, N
v_r, v_t radial and tangential sliding speed of the belt against the pulley, in units of omega R a Delta
psi     direction of sliding, tan psi = v_t/v_r; positive psi: the belt runs ahead of the pulley
beta_s  angle of the sliding velocity against the plane of rotation
A       speed of ratio change, dR/dt = A omega R a Delta (0 in steady state)
B       creep, V = omega R (1 + a Delta B)

Equations
---------
(1) v_r = A + sin(theta - theta_c)                      belt follows the groove
(2) v_t = B + cos(theta - theta_c) - A theta            d v_t/d theta = -v_r: the belt does not stretch
(3) tan psi = v_t/v_r,  tan beta_s = tan beta cos psi
(4) F' = 2 p R (sin beta - mu cos beta_s cos psi)       radial balance
(5) dF'/d theta = 2 p R mu cos beta_s sin psi           tangential balance, hence
    d ln F'/d theta = mu cos beta_s sin psi/(sin beta - mu cos beta_s cos psi)
(6) S = int p (cos beta + mu sin beta_s) R d theta      axial balance of a sheave
(7) tan theta_c = int p_ax sin theta/int p_ax cos theta with p_ax = p (cos beta + mu sin beta_s)

In steady state the equations do not depend on Delta, omega and R: for given wrap, beta and mu an arc has the single
parameter B, which determines the force ratio F'_out/F'_in, theta_c and S/F'.

Signs
-----
Forward running: the belt enters the primary pulley P from the upper strand (F_1) and leaves it to the lower, push
strand (F_2); on the secondary S the directions are reversed. The traction is

    r = (F_1 - F_2)/(F_1 + F_2 - 2 sigma V^2)

An engine that drives P has T_P > 0, F_1 > F_2 and r > 0: F falls along P (ln F'_out/F'_in = -2 artanh r, belt slower
than the pulley) and rises along S. Braking has r < 0. T_P = (F_1 - F_2) R_P.

Range of validity
-----------------
0 < mu < tan beta (else the groove is self-locking where the belt slides outward); belt width and length rigid compared
with the groove's opening; Delta small; F' > 0 in both strands; chain closed (elements touch) wherever the belt is loaded.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from math import asin, atan2, atanh, cos, inf, pi, sin, sqrt, tan, tanh

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

Array = NDArray[np.float64]

GAUSS_POINTS = 8
"""Gauss points per panel."""

PANELS = 24
"""Panels on each side of a turning point of psi."""

FINEST_PANEL = 1.0e-7
"""Smallest panel relative to the graded length: psi changes within |B + 1| when the creep is near -1."""

EVEN, GRADED = np.linspace(0.0, 1.0, PANELS + 1), np.concatenate([[0.0], np.geomspace(FINEST_PANEL, 1.0, PANELS)])
"""Borders of panels on half a piece of the arc: at its ends, and towards a turning point."""


def deformation_factor(beta: float) -> float:
    """a in R (1 - a Delta cos(theta - theta_c)): one half is from the groove's angle, one from its width."""
    return (1.0 + cos(beta) ** 2) / sin(2.0 * beta)


# --------------------------------------------------------------------------------------------------------- one arc


@dataclass(frozen=True)
class Arc:
    """Solution on the arc of one pulley. Forces in units of the mean reduced strand force (F'_in + F'_out)/2."""

    wrap: float
    beta: float
    mu: float
    creep: float
    """B"""
    shift: float
    """A"""
    centre: float
    """theta_c"""
    log_ratio: float
    """ln F'_out/F'_in"""
    thrust: float
    """S"""
    moment: float
    """|int p_ax (cos theta, sin theta) R d theta|/S: the tilting moment is moment * S * R"""
    theta: Array
    tension: Array
    """F'(theta)"""
    pressure: Array
    """p(theta) R: normal force per flank and angle"""
    axial_pressure: Array
    """p_ax(theta) R"""
    psi: Array

    @property
    def traction(self) -> float:
        """(F'_out - F'_in)/(F'_out + F'_in): positive on a driven pulley."""
        return tanh(self.log_ratio / 2.0)

    @property
    def mean_sliding(self) -> float:
        """Tangential sliding of the belt weighted by axial pressure, in units of omega R a Delta; steady state."""
        return self.creep + self.moment

    @property
    def dissipation(self) -> float:
        """Friction power in units of omega R a Delta; steady state. The power of friction, integrated by parts with
        (2), (4) and (7), is F' v_t at the exit minus F' v_t at the entry."""
        v_t = sliding(np.array([0.0, self.wrap]), self.centre, self.creep)[1]
        return float(self.tension[-1] * v_t[1] - self.tension[0] * v_t[0])


@cache
def _gauss(points: int) -> tuple[Array, Array, Array]:
    """Nodes and weights on [-1, 1], and the matrix that integrates nodal values from -1 to each node."""
    nodes, weights = legendre.leggauss(points)
    to_series = np.linalg.inv(legendre.legvander(nodes, points - 1))
    antiderivatives = np.array([legendre.legval(nodes, legendre.legint(row, lbnd=-1.0)) for row in np.eye(points)])
    return nodes, weights, antiderivatives.T @ to_series


def sliding(theta: Array, centre: float, creep: float, shift: float = 0.0) -> tuple[Array, Array]:
    """Equations (1) and (2): v_r, v_t in units of omega R a Delta."""
    return shift + np.sin(theta - centre), creep + np.cos(theta - centre) - shift * theta


def _friction(psi: Array, beta: float, mu: float) -> tuple[Array, Array, Array]:
    """Per unit of normal force and flank: outward radial, tangential (on the sheave) and axial force."""
    beta_s = np.arctan(tan(beta) * np.cos(psi))
    radial = sin(beta) - mu * np.cos(beta_s) * np.cos(psi)
    tangential = mu * np.cos(beta_s) * np.sin(psi)
    axial = cos(beta) + mu * np.sin(beta_s)
    return radial, tangential, axial


def _turning_points(wrap: float, centre: float, shift: float) -> list[float]:
    """Places on the arc with v_r = 0. There v_t is extreme and psi may change abruptly."""
    if abs(shift) >= 1.0:
        return []
    lag = asin(shift)
    places = (centre + turn * pi - (-1) ** turn * lag for turn in range(-2, 3))
    return [place for place in places if 0.0 < place < wrap]


def _panels(wrap: float, turning_points: list[float]) -> Array:
    """Panel borders, graded geometrically towards every turning point."""
    borders = [0.0, *turning_points, wrap]
    pieces = [np.array(borders)]
    for k, (left, right) in enumerate(zip(borders[:-1], borders[1:])):
        half = (right - left) / 2.0
        pieces.append(left + half * (GRADED if k > 0 else EVEN))
        pieces.append(right - half * (GRADED if k + 2 < len(borders) else EVEN))
    panels = np.unique(np.concatenate(pieces))
    return panels[np.concatenate([[True], np.diff(panels) > 1.0e-14])]


@dataclass(frozen=True)
class _Integrals:
    log_ratio: float
    thrust: float  # in units of F'_in
    moment: float
    direction: float
    borders: Array
    log_tension: Array  # at the borders, 0 at entry


def _integrate(wrap: float, beta: float, mu: float, creep: float, centre: float, shift: float = 0.0) -> _Integrals:
    """Equations (3) to (7) for a given B and theta_c. psi depends on theta only, so they are solved by quadrature."""
    nodes, weights, cumulate = _gauss(GAUSS_POINTS)
    borders = _panels(wrap, _turning_points(wrap, centre, shift))
    widths = np.diff(borders)
    theta = borders[:-1, None] + widths[:, None] * (nodes + 1.0) / 2.0
    v_r, v_t = sliding(theta, centre, creep, shift)
    radial, tangential, axial = _friction(np.arctan2(v_t, v_r), beta, mu)
    growth = tangential / radial
    log_border = np.concatenate([[0.0], np.cumsum((growth @ weights) * widths / 2.0)])
    tension = np.exp(log_border[:-1, None] + (growth @ cumulate.T) * widths[:, None] / 2.0)
    load = tension / (2.0 * radial) * axial * weights * widths[:, None] / 2.0
    thrust = float(load.sum())
    x, y = float((load * np.cos(theta)).sum()), float((load * np.sin(theta)).sum())
    return _Integrals(float(log_border[-1]), thrust, sqrt(x * x + y * y) / thrust, atan2(y, x) % (2.0 * pi), borders, log_border)


def _check(wrap: float, beta: float, mu: float) -> None:
    if not 0.0 < wrap < 2.0 * pi:
        raise ValueError(f"wrap angle {wrap} rad is not between 0 and 2 pi")
    if not 0.0 < beta < pi / 2.0:
        raise ValueError(f"half wedge angle {beta} rad is not between 0 and pi/2")
    if not 0.0 < mu < tan(beta):
        raise ValueError(f"mu = {mu} is not between 0 and tan beta = {tan(beta):.4f}: the groove is self-locking")


@lru_cache(maxsize=100_000)
def _centre(wrap: float, beta: float, mu: float, creep: float, shift: float = 0.0) -> float:
    """theta_c of equation (7), as a fixed point: the pressure determines the opening of the groove and depends on it."""

    def excess(centre: float) -> float:
        return centre - _integrate(wrap, beta, mu, creep, centre, shift).direction

    return float(brentq(excess, 1.0e-9, wrap - 1.0e-9, xtol=1.0e-13, rtol=1.0e-14))


def log_ratio(wrap: float, beta: float, mu: float, creep: float, shift: float = 0.0) -> float:
    centre = _centre(wrap, beta, mu, creep, shift)
    return _integrate(wrap, beta, mu, creep, centre, shift).log_ratio


def creep_of(u: float) -> float:
    """Maps the search variable to B = -1 + sinh u, with fine resolution about -1, where theta_c and psi change fastest."""
    return -1.0 + float(np.sinh(u))


@cache
def _creep_range(wrap: float, beta: float, mu: float) -> tuple[float, float]:
    """Search variable between the extremes of ln F'_out/F'_in: the branch that contains idle running."""
    grid = np.array([-16.0, *np.linspace(-4.0, 4.0, 33), 16.0])  # Beyond 4 the belt nearly slips through.
    values = np.array([log_ratio(wrap, beta, mu, creep_of(u)) for u in grid])

    def extreme(index: int, sign: float) -> float:
        if index in (0, grid.size - 1):
            return float(grid[index])
        found = minimize_scalar(
            lambda u: -sign * log_ratio(wrap, beta, mu, creep_of(float(u))),
            bounds=(grid[index - 1], grid[index + 1]),
            method="bounded",
            options={"xatol": 1.0e-6},
        )
        return float(found.x)

    return extreme(int(values.argmin()), -1.0), extreme(int(values.argmax()), 1.0)


def arc_capacity(wrap: float, beta: float, mu: float) -> tuple[float, float]:
    """Least (driving pulley, negative) and greatest (driven) ln F'_out/F'_in of an arc. Full tangential slip gives -+
    mu wrap/sin beta. A driving pulley transmits slightly more just before full slip, because the belt still slides
    outward over most of the arc, which presses the flanks together."""
    _check(wrap, beta, mu)
    low, high = _creep_range(wrap, beta, mu)
    full_slip = mu * wrap / sin(beta)
    ends = [log_ratio(wrap, beta, mu, creep_of(u)) for u in (low, high)]
    return min(ends[0], -full_slip), max(ends[1], full_slip)


def arc_at_creep(wrap: float, beta: float, mu: float, creep: float, shift: float = 0.0, points: int = 181) -> Arc:
    """Arc for a creep B and a speed of ratio change A; fields at `points` evenly spaced places."""
    _check(wrap, beta, mu)
    centre = _centre(wrap, beta, mu, creep, shift)
    whole = _integrate(wrap, beta, mu, creep, centre, shift)
    unit = (1.0 + np.exp(whole.log_ratio)) / 2.0
    theta = np.linspace(0.0, wrap, points)
    # Borders are dense where psi changes; between them ln F' is smooth with a known slope.
    v_r, v_t = sliding(whole.borders, centre, creep, shift)
    radial, tangential, _ = _friction(np.arctan2(v_t, v_r), beta, mu)
    tension = np.exp(CubicHermiteSpline(whole.borders, whole.log_tension, tangential / radial)(theta)) / unit
    v_r, v_t = sliding(theta, centre, creep, shift)
    psi = np.arctan2(v_t, v_r)
    radial, _, axial = _friction(psi, beta, mu)
    pressure = tension / (2.0 * radial)
    return Arc(
        wrap, beta, mu, creep, shift, centre, whole.log_ratio, whole.thrust / unit, whole.moment,
        theta, tension, pressure, pressure * axial, psi,
    )  # fmt: skip


@lru_cache(maxsize=100_000)
def arc_at_traction(wrap: float, beta: float, mu: float, traction: float, points: int = 181) -> Arc:
    """Steady arc with (F'_out - F'_in)/(F'_out + F'_in) = traction, negative on a driving pulley. Near capacity a
    driving pulley has a second solution, closer to full slip; this is the one with the smaller creep."""
    _check(wrap, beta, mu)
    wanted = 2.0 * atanh(traction)
    low, high = _creep_range(wrap, beta, mu)
    ends = [log_ratio(wrap, beta, mu, creep_of(u)) for u in (low, high)]
    if not ends[0] < wanted < ends[1]:
        raise ValueError(f"traction {traction:.4f} is beyond the capacity of an arc of {wrap:.4f} rad")
    u = brentq(lambda u: log_ratio(wrap, beta, mu, creep_of(u)) - wanted, low, high, xtol=1.0e-12)
    return arc_at_creep(wrap, beta, mu, creep_of(float(u)), points=points)


# ----------------------------------------------------------------------------------------------------- two pulleys


@dataclass(frozen=True)
class Variator:
    """Steady belt on two pulleys; forces in units of the mean reduced strand force (F_1 + F_2)/2 - sigma V^2."""

    traction: float
    """r, positive when P drives"""
    primary: Arc
    secondary: Arc

    @property
    def thrust_ratio(self) -> float:
        """S_P/S_S"""
        return self.primary.thrust / self.secondary.thrust

    @property
    def torque_number(self) -> float:
        """T_P/(S_S R_P)"""
        return 2.0 * self.traction / self.secondary.thrust

    def mean_force(self, secondary_thrust: float) -> float:
        """(F_1 + F_2)/2 - sigma V^2 in N for an axial force on S in N."""
        return secondary_thrust / self.secondary.thrust


def wrap_angles(ratio: float, center_distance: float, pitch_length: float) -> tuple[float, float, float, float]:
    """alpha_P, alpha_S, R_P, R_S of a belt of this length at R_S/R_P = ratio."""

    def excess(radius: float) -> float:
        difference = (1.0 - ratio) * radius
        lean = asin(difference / center_distance)
        return (
            2.0 * sqrt(center_distance**2 - difference**2)
            + radius * (pi + 2.0 * lean)
            + ratio * radius * (pi - 2.0 * lean)
            - pitch_length
        )

    widest = center_distance / abs(1.0 - ratio) if ratio != 1.0 else inf
    radius = float(brentq(excess, 1.0e-6, min(0.999999 * widest, pitch_length), xtol=1.0e-14))
    lean = asin((1.0 - ratio) * radius / center_distance)
    return pi + 2.0 * lean, pi - 2.0 * lean, radius, ratio * radius


def capacity(wrap_p: float, wrap_s: float, beta: float, mu: float, driving: bool = True) -> float:
    """Largest |r| for which both pulleys have a solution; P drives or brakes."""
    driver, driven = (wrap_p, wrap_s) if driving else (wrap_s, wrap_p)
    return tanh(min(-arc_capacity(driver, beta, mu)[0], arc_capacity(driven, beta, mu)[1]) / 2.0)


def variator(wrap_p: float, wrap_s: float, beta: float, mu: float, traction: float) -> Variator:
    """Both pulleys at traction r. F falls along P by the same amount by which it rises along S."""
    return Variator(traction, arc_at_traction(wrap_p, beta, mu, -traction), arc_at_traction(wrap_s, beta, mu, traction))


def variator_at_torque(
    wrap_p: float, wrap_s: float, beta: float, mu: float, radius_p: float, torque: float, secondary_thrust: float
) -> Variator:
    """Both pulleys for a torque T_P (N m) and an axial force S_S (N). sigma V^2 adds the same value to both strand
    forces and cancels in this relation."""
    wanted = torque / (secondary_thrust * radius_p)

    def excess(u: float) -> float:
        arc = arc_at_creep(wrap_s, beta, mu, creep_of(u))
        return 2.0 * arc.traction / arc.thrust - wanted

    low, high = _creep_range(wrap_s, beta, mu)
    if excess(low) * excess(high) > 0.0:
        raise ValueError(f"torque {torque:.3f} N m is beyond the capacity at S_S = {secondary_thrust:.1f} N")
    found = arc_at_creep(wrap_s, beta, mu, creep_of(float(brentq(excess, low, high, xtol=1.0e-12))))
    return Variator(found.traction, arc_at_traction(wrap_p, beta, mu, -found.traction), found)


# ------------------------------------------------------------------------------- the older theory, for comparison


def rest_and_slip_arc(wrap_p: float, wrap_s: float, beta: float, mu: float, traction: float) -> tuple[float, float, float, float]:
    """Rigid pulleys, elastic belt (Eytelwein, Grashof): S_P/S_S, slip arc (rad), S_P and S_S per mean reduced force.
    From the entry on the belt rests on the pulley with constant force; over the slip arc before the exit it creeps
    tangentially and the force changes by exp(mu gamma/sin beta). There is no radial friction."""
    slip_arc = 2.0 * atanh(abs(traction)) * sin(beta) / mu
    if slip_arc > min(wrap_p, wrap_s):
        raise ValueError(f"traction {traction:.4f} needs a slip arc of {slip_arc:.4f} rad")
    # In the slip arc T = 2 mu S R/cos beta, whatever its length.
    slipping = abs(traction) * cos(beta) / mu
    entry_p, entry_s = 1.0 + traction, 1.0 - traction
    thrust_p = entry_p * (wrap_p - slip_arc) / (2.0 * tan(beta)) + slipping
    thrust_s = entry_s * (wrap_s - slip_arc) / (2.0 * tan(beta)) + slipping
    return thrust_p / thrust_s, slip_arc, thrust_p, thrust_s
