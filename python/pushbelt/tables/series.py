"""Plateaus of a time series: stretches in which no channel changes, each averaged to a row."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from .names import DEVIATION
from .sheet import Fault, Sheet

Array = np.ndarray

FEWEST = 20  # Rows from which a table with ascending times may be a time series
MANY = 200  # Rows from which a table is one in any case: so many points are not measured one by one
HALF, SAMPLES = 0.25, 3
"""The means of two adjacent windows are compared: their length in seconds, and their least number of samples. A plateau is at least three
windows long; its first and last one are not averaged, since the rig settles there."""
WITHOUT_TIME = 25  # Samples of a window if the table has no times
NOISE = 5.0  # A change above this multiple of the usual scatter of the differences ends a plateau …
LEAST, LARGEST = 0.003, 0.02  # … but not one below the first share of the channel's level, and any above the second
SPIKE = 8.0  # A sample that is further from the plateau's median, in standard deviations, is not averaged


def averaged(sheet: Sheet, time: str, names: Sequence[str], name: str) -> Sheet:
    """A time series as a row for each plateau, with the standard errors; any other table as it is. `names` are the channels that are
    compared, `name` the column for the plateaus' names."""
    import pandas as pd

    channels = {channel: sheet.values[channel] for channel in names if channel in sheet.values}
    timed = time in sheet.values
    times = sheet.values[time].copy() if timed else np.arange(len(sheet), dtype=float)
    good = np.isfinite(times)
    steps = [np.diff(times[good & np.isfinite(values)]) for values in channels.values()]
    step = min((float(np.median(own)) for own in steps if len(own)), default=0.0)
    if good.sum() < (FEWEST if timed else MANY) or not (np.diff(times[good]) >= 0.0).all() or step <= 0.0:
        return sheet
    half = max(SAMPLES, round(HALF / step)) if timed else WITHOUT_TIME
    # A pause of the recording has the length of two windows.
    times[good] -= np.cumsum(np.maximum(np.diff(times[good], prepend=times[good][0]) - 2 * half * step, 0.0))
    grid = np.arange(times[good][0], times[good][-1] + 0.5 * step, step)
    own = {channel: good & np.isfinite(values) for channel, values in channels.items()}
    raw = pd.DataFrame({c: np.interp(grid, times[there], channels[c][there]) for c, there in own.items() if there.any()})
    # Without spikes of one or two samples.
    found = _plateaus(raw.rolling(5, center=True, min_periods=1).median().to_numpy(), raw.to_numpy(), half)
    enough = sum(end - start + 2 * half for start, end in found) > 0.5 * len(grid)
    if not enough and (not timed or step > 2.0 or len(sheet) < MANY):
        return sheet
    drifting = [span for span in found if any(_drifts(values, span) for values in raw.to_numpy().T)]
    spans = [(grid[start] - 0.5 * step, grid[end - 1] + 0.5 * step) for start, end in found if (start, end) not in drifting]
    reduced, described = _rows(sheet, times, spans, time, name, raw.columns)
    length = f" and {np.ptp(times[good]):.4g} s" if timed else ""
    reduced.remarks += [
        f"a time series of {len(sheet)} rows{length}: {len(spans)} plateaus",
        *(f"from {grid[start]:.4g} to {grid[end - 1]:.4g} s the channels drift: not used" for start, end in drifting),
        *described,
    ]
    if not spans:
        why = f": in {len(drifting)} stretches the channels drift" if drifting else ""
        text = f"a time series without a plateau of {3 * half * step:.3g} s{why}; for recorded shifts add a column series"
        reduced.faults.append(Fault(text))
    return reduced


def _plateaus(even: Array, raw: Array, half: int) -> list[tuple[int, int]]:
    """Spans without a change in any channel, at least a window long. The windows before and after a place are within the plateau."""
    count = len(raw) - 2 * half + 1
    if count < half:
        return []
    sums = np.concatenate([np.zeros((1, raw.shape[1])), np.cumsum(even - even[0], axis=0)])
    means = (sums[half:] - sums[:-half]) / half
    change = np.abs(means[half:] - means[:-half])
    level = np.quantile(np.abs(even), 0.95, axis=0)
    # The scatter of the quieter half of the places, and that of white noise: the first one includes slow noise.
    usual = np.quantile(change, 0.4, axis=0) / 0.524
    white = np.median(np.abs(np.diff(raw, axis=0)), axis=0) / 0.954 * np.sqrt(2.0 / half)
    limit = np.minimum(np.maximum(NOISE * usual, LEAST * level), np.maximum(LARGEST * level, NOISE * white))
    steady = (change <= limit).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(int)))
    spans = zip(edges[::2], edges[1::2], strict=True)
    return [(start + half, end + half) for start, end in spans if end - start >= half]


def _drifts(values: Array, span: tuple[int, int]) -> bool:
    """Whether the first and the last third of a span differ by more than the plateau's tolerance."""
    own = values[slice(*span)]
    third = max(len(own) // 3, 1)
    apart = abs(own[:third].mean() - own[-third:].mean())
    return bool(apart > max(LARGEST * np.quantile(np.abs(values), 0.95), NOISE * own.std() * np.sqrt(2.0 / third)))


def _rows(
    sheet: Sheet, times: Array, spans: Sequence[tuple[float, float]], time: str, name: str, channels: Iterable[str]
) -> tuple[Sheet, list[str]]:
    """A row for each span, with means and standard errors of the means; and each span in words, in the units of the file."""
    values = {channel: np.full(len(spans), np.nan) for channel in sheet.values if channel != time}
    errors = {channel: np.full(len(spans), np.nan) for channel in values if not channel.endswith(DEVIATION)}
    lines, spikes, described = np.zeros(len(spans), dtype=int), 0, []
    for row, (start, end) in enumerate(spans):
        inside, parts = (times >= start) & (times < end), {}
        own_lines = sheet.lines[inside]
        lines[row] = own_lines[0]
        for channel in values:
            column, one = sheet.values[channel], sheet.taken[channel]
            there = np.isfinite(column)
            own = column[inside & there]
            if not own.size and there.sum() > 1:
                # A channel with a slower raster than the plateau.
                there &= np.isfinite(times)
                own = np.interp([0.5 * (start + end)], times[there], column[there])
            kept = _kept(own)
            spikes += own.size - kept.size
            values[channel][row] = kept.mean() if own.size else np.nan
            if channel in errors and kept.size > 1:
                errors[channel][row] = kept.std(ddof=1) / np.sqrt(kept.size)
            spread = f" ± {one.written(kept).std(ddof=1):.2g}" if own.size > 1 else ""
            parts[channel] = f"{one.title} {one.written(values[channel][row]):.5g}{spread}"
        ends = f"{start:.4g} to {end:.4g} s, lines {own_lines[0]} to {own_lines[-1]}, {own_lines.size} samples"
        described.append(f"plateau {row + 1}: {ends}: {'; '.join(parts[channel] for channel in channels)}")
    texts = {name: np.array([f"plateau {row}" for row in range(1, len(spans) + 1)], dtype=object)}
    remarks = [*sheet.remarks, *[f"{spikes} samples far from their plateau are not averaged"] * (spikes > 0)]
    return replace(sheet, values=values, texts=texts, lines=lines, errors=errors, remarks=remarks), described


def _kept(values: Array) -> Array:
    """Values without spikes."""
    if len(values) <= 2 * SAMPLES:
        return values
    apart = np.abs(values - np.median(values))
    limit = SPIKE * 1.4826 * np.median(apart)  # 1.4826 medians of the distances are a standard deviation
    return values[apart <= limit] if limit > 0.0 else values
