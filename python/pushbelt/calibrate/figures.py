"""Residuals over the working points, and model over measurement, before and after the fit."""

from __future__ import annotations

from pushbelt import residual_figures
from pushbelt.report.charts import Chart
from pushbelt.residual_figures import Residual

from .results import Results, Row


def residuals(results: Results, quantity: str) -> Chart:
    """Figures of a quantity. The values after the fit determine the axes, since those at the start may be far off."""
    rows = results.of(quantity)
    return residual_figures.residuals(quantity, {"fitted": _of(rows, "after"), "start values": _of(rows, "before")})


def _of(rows: list[Row], side: str) -> list[Residual]:
    return [
        Residual(
            row.point.name or f"line {row.point.line}",
            row.point.torque,
            row.point.ratio or row.point.speed_ratio,
            row.measured.value,
            getattr(row, side),
            row.measured.deviation,
        )
        for row in rows
        if getattr(row, side) is not None
    ]
