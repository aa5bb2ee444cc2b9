"""Statements of 5.3, on rings alone, and of 3.1."""

from __future__ import annotations

import numpy as np

from .rings import Motion, Rings
from .statement import Statement, listed, plain, signed, verdict

REFERENCE_DIRECTIONS = "ALE, overlay along t and n"
"""ALE with A_i = [t, n]."""


def short_name(model: str) -> str:
    """Name of a model in statements."""
    return {REFERENCE_DIRECTIONS: "ALE [t, n]"}.get(model, model.replace("evenly spaced mesh", "even mesh"))


def _centre(rings: Rings, model: str) -> float:
    """Displacement of the centre of mass of a ring of fig. 7 along x, m."""
    centres = [outline[:-1, 0].mean() for outline in rings.shapes["7", model].values()]
    return max(centres, key=lambda x: abs(x - centres[0])) - centres[0]


def _crossings(motion: Motion) -> int:
    """Number of sign changes of the ovality."""
    return int(np.count_nonzero(np.diff(np.sign(motion.ovality))))


def _reference_motion(rings: Rings) -> list[Statement]:
    """Statements on fig. 6 and on the repeated motions."""
    motion = rings.motions["6", "ALE0"]
    low, high, drift = motion.theta.min(), motion.theta.max(), np.abs(motion.drift).max()
    locked, free = (
        rings.check(f"smallest/largest eigenvalue of M, {what}", "ALE, 8 elements").value
        for what in ("node 0 locked", "nothing locked")
    )
    return [
        Statement(
            "5.3, fig. 6",
            "The reference motion alone, started in overdrive, oscillates about ratio 1",
            verdict(abs(low + 0.4) < 0.02 and abs(high - 0.4) < 0.02),
            f"Θ from {plain(low, '+.3f')} to {plain(high, '+.3f')}",
            "Bending energy is smallest where both radii are equal, and there is no dissipation.",
        ),
        Statement(
            "5.3",
            "The drift is zero to rounding",
            verdict(drift < 1e-9),
            f"|s| ≤ {plain(drift, '.0e')} m",
            "M_sΘ vanishes by symmetry.",
        ),
        Statement(
            "5.3",
            "Drift and ratio repeat motions of the overlay: M is singular until a node is locked",
            verdict(free < 1e-3 * locked, free < locked),
            "smallest over largest eigenvalue of M, each unknown scaled to unit mass: "
            f"{plain(free, '.0e')} free, {plain(locked, '.0e')} locked",
            "Eight cubic elements repeat the two motions only approximately, because arcs are not cubic.",
        ),
    ]


def _deformable_ring(rings: Rings) -> list[Statement]:
    """Fig. 7."""
    fig7 = {model: motion for (figure, model), motion in rings.motions.items() if figure == "7"}
    ale = fig7["ALE"]
    turned = _crossings(ale) >= 2
    return [
        Statement(
            "5.3, fig. 7",
            "Released from the belt's shape, the strands bulge outwards first",
            verdict(all(motion.bulge[4] > 2e-3 for motion in fig7.values())),
            "at 0.2 ms, in mm: " + listed({short_name(name): f"{1e3 * m.bulge[4]:.1f}" for name, m in fig7.items()}),
            "The straight strands bend to relieve the arcs.",
        ),
        Statement(
            "5.3, fig. 7",
            "Then the node that is locked to the reference curve changes the ratio, and the ring takes an overdrive shape that "
            "does not occur in a free ring",
            verdict(ale.theta.max() > 0.6),
            f"Θ rises from 0.4 to {ale.theta.max():.2f} at {1e3 * ale.time[int(ale.theta.argmax())]:.2f} ms; until "
            f"{1e3 * ale.time[-1]:.0f} ms the centre of mass moves by {1e3 * abs(_centre(rings, 'ALE')):.0f} mm (RCM: "
            f"{1e3 * abs(_centre(rings, 'RCM')):.1f} mm)",
            "The left end has to move inwards, which only Θ permits. The lock transmits a force, because the bending measure (23) "
            "is relative to the curve and resists a change of Θ alone: energy is conserved, but the lock takes up momentum. With Θ held "
            "instead of the node the centre of mass is at rest to rounding (paper/tests/ring/ale.rs). RCM and ANCF have no such lock.",
        ),
        Statement(
            "5.3, fig. 7",
            "After that it becomes an oval",
            verdict(turned),
            f"ovality of ALE changes its sign {_crossings(ale)} times in {1e3 * ale.time[-1]:.1f} ms, of RCM {_crossings(fig7['RCM'])}"
            + ("" if turned else f"; the run ends with Θ = {ale.theta[-1]:.2f}"),
            "The oval differs from that of RCM, because the ring is far from its reference at that time."
            if turned
            else "At the left end of a circle the radius of S would be almost zero: Θ tends to 1, the limit of the two-pulley curve.",
        ),
    ]


def _accuracy_and_effort(rings: Rings) -> list[Statement]:
    """Statements on frequencies and on the cost of the directions of the overlay."""
    small = [f for f in rings.frequencies if f.case == "circle, small" and f.elements == 40]
    large = {f.model: f for f in rings.frequencies if f.case != "circle, small"}
    fixed, turning = (rings.effort("deformable ring, 0.3 ms", model) for model in ("ALE", REFERENCE_DIRECTIONS))
    return [
        Statement(
            "5.3",
            "Small deflections from the reference are quantitatively correct",
            verdict(all(abs(f.error) < 5e-3 for f in small)),
            "first frequency of a free band, 40 elements: " + listed({short_name(f.model): signed(f.error, 2) for f in small}),
            "On a circular reference curve, against the thin ring's 9.534 Hz.",
        ),
        Statement(
            "5.3, 5.4",
            "Large deflections from the reference are not",
            verdict(abs(large["ALE"].error) > 0.02 and abs(large["RCM"].error) < 0.01),
            "large oscillation, against 9.23 Hz: " + listed({short_name(m): f"{f.frequency:.2f}" for m, f in large.items()}),
            "The bending measure (23) is linear in the deflection.",
        ),
        Statement(
            "3.1, 5.4",
            "A_i = identity computes faster than A_i = [t, n]",
            # By counts, since a verdict may not depend on a clock.
            verdict(turning.factorizations > 1.05 * fixed.factorizations, turning.factorizations > fixed.factorizations),
            f"[t, n] takes {signed(turning.cpu / fixed.cpu - 1.0, 0)} of processor time, {turning.factorizations:.0f} Jacobians against "
            f"{fixed.factorizations:.0f}",
            "A_i = identity has fewer derivatives; nodes that rotate with Θ are coupled to it more strongly.",
        ),
    ]


def rings_alone(rings: Rings) -> list[Statement]:
    """All statements on rings, in the paper's order."""
    return [*_reference_motion(rings), *_deformable_ring(rings), *_accuracy_and_effort(rings)]
