"""Statements of 3.1 on the directions of the overlay in the variator, of section 6 on space, and the proposals of section 7."""

from __future__ import annotations

from .cases import OFFSET
from .results import PaperResults
from .statement import Statement, Verdict, verdict


def _directions(results: PaperResults) -> Statement:
    fixed, turning = (results.shifts[name] for name in ("aligned", "directions"))
    return Statement(
        "3.1, 5.4",
        "A_i = [t, n] behaves numerically unfavourably in the variator, because Θ oscillates",
        verdict(turning.jacobians > 1.2 * fixed.jacobians, turning.jacobians > 1.05 * fixed.jacobians),
        f"a shift takes {turning.jacobians} Jacobians with [t, n] and {fixed.jacobians} with the identity",
        "Implicit steps with exact derivatives follow oscillations of Θ in either directions. In the manoeuvre [t, n] takes fewer Jacobians "
        "(docs/paper.md); it costs more because its derivatives do.",
    )


def _space(results: PaperResults) -> Statement:
    state = results.misaligned
    return Statement(
        "6",
        "Spatial simulations of pushbelts are possible",
        verdict(state["belt.lateralMax"] > 0.1 * OFFSET and state["belt.skew"] != 0.0),
        f"pulleys {1e3 * OFFSET:g} mm out of line: the ring deflects sideways by {1e3 * state['belt.lateralMax']:.2f} mm, the strands are "
        f"inclined by {1e3 * state['belt.skew']:.2f} mrad, efficiency of the belt {100 * state['efficiency.belt']:.2f} %",
        "The ring has bending and membrane stiffness along z too; the elements stay upright.",
    )


PROPOSALS = (
    ("Other belt systems", "paper/examples/idler.rs", "The ring runs around two pulleys and an idler on its back, and on any closed curve."),
    (
        "Separated integration of reference and overlay",
        "docs/lab/experiments.md",
        "A sweep reduces the error by 2 to 3 % only: s and Θ repeat motions of the overlay. Not taken.",
    ),
    (
        "Reduced overlay",
        "docs/lab/experiments.md",
        "Half of all modes are needed for 5 % of the ring tension, which is EA times small differences. Not taken.",
    ),
)
"""What section 7 proposes, where it was measured, and the result."""


def outlook(results: PaperResults) -> list[Statement]:
    """All of them."""
    proposals = [Statement("7", claim, Verdict.ASIDE, place, result) for claim, place, result in PROPOSALS]
    return [_directions(results), _space(results), *proposals]
