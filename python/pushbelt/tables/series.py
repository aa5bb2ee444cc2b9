"""Plateaus of a recording: stretches in which no channel changes, each averaged to a row."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from ..fmu.geometry import Array
from ..fmu.results import intervals
from .names import DEVIATION
from .sheet import Fault, Sheet

MANY = 200  # Rows from which a table with times at most `RASTER` apart is a time series, also if it never rests
RASTER = 2.0  # s
HALF, SAMPLES = 0.25, 3
"""The means of two adjacent windows are compared: their length in seconds, and their least number of samples. A plateau is at least three
windows long; its first and last one are not averaged, since the rig settles there."""
WITHOUT_TIME = 25  # Samples of a window if the table has no times
NEAR = 0.1  # Rows that agree differ by at most this share of a channel's range
NOISE = 5.0  # A change above this multiple of the usual scatter of the differences ends a plateau …
LEAST, LARGEST = 0.003, 0.02  # … but not one below the first share of the channel's level, and any above the second
SPIKE = 12.0  # A sample that is further from the plateau's median, in medians of these distances, is not averaged: 8 standard deviations


def averaged(sheet: Sheet, time: str, step: str, names: Sequence[str], name: str, as_points: bool = False) -> Sheet:
    """A recording as a row for each plateau, with the standard errors; any other table as it is. `names` are the channels that are
    compared, `time` and `step` the columns of times and of the numbers of a program's steps, `name` that for the plateaus' names.
    Without times a recording can be taken `as_points`."""
    channels = {channel: sheet.values[channel] for channel in names if channel in sheet.values}
    texts = sheet.texts.get(step, np.empty(0))
    labels = np.cumsum(np.append(False, texts[1:] != texts[:-1])) if len(texts) else None  # Numbers that change where the step does
    times = sheet.values.get(time, np.full(len(sheet), np.nan))
    timed = max(_rasters(times, channels.values()), default=0.0) > 0.0 and bool((np.diff(times[np.isfinite(times)]) >= 0.0).all())
    remark = ["the times do not ascend: the rows are taken as equally apart"] * (not timed and bool(np.isfinite(times).any()))
    times = times if timed else np.arange(len(sheet), dtype=float)
    good = np.isfinite(times)
    raster = min(_rasters(times, channels.values()), default=0.0)
    together = _together(len(sheet), channels.values())
    # Different points may have a step in common, too.
    inside = np.zeros(1, dtype=bool) if labels is None or labels[-1] == 0 else together[np.diff(labels) == 0]
    stepped = bool(inside.size) and inside.mean() > 0.5
    recorded = timed and raster <= RASTER and len(sheet) >= MANY
    if raster <= 0.0 or not (stepped or recorded or (together.mean() > 0.5 and (timed or not as_points))):
        return sheet
    sheet.remarks += remark
    half = max(SAMPLES, round(HALF / raster)) if timed else WITHOUT_TIME
    # A pause of the recording has the length of two windows.
    apart = np.maximum(np.diff(times[good], prepend=times[good][0]) - 2 * half * raster, 0.0)
    own_times = times.copy()
    own_times[good] -= np.cumsum(apart)
    grid = np.arange(own_times[good][0], own_times[good][-1] + 0.5 * raster, raster)
    own = {channel: good & np.isfinite(values) for channel, values in channels.items()}
    raw = pd.DataFrame({c: np.interp(grid, own_times[there], channels[c][there]) for c, there in own.items() if there.any()})
    # Without spikes of one or two samples.
    found = _plateaus(raw.rolling(5, center=True, min_periods=1).median().to_numpy(), raw.to_numpy(), half)
    enough = sum(end - start + 2 * half for start, end in found) > 0.5 * len(grid)
    if not enough and (stepped or not (timed and len(sheet) >= MANY)):
        # Rows of a step, or that agree with the one above, in place of windows.
        runs = np.flatnonzero(np.diff(labels) if stepped and labels is not None else ~together) + 1
        found = [(start, end) for start, end in zip([0, *runs], [*runs, len(sheet)], strict=True) if end - start > 1]
        own_times, grid, raster = np.arange(len(sheet), dtype=float), np.arange(len(sheet), dtype=float), 1.0
        raw = pd.DataFrame(channels).interpolate(limit_direction="both")
    drifting = [span for span in found if any(_drifts(values, span) for values in raw.to_numpy().T)]
    spans = [(grid[start] - 0.5 * raster, grid[end - 1] + 0.5 * raster) for start, end in found if (start, end) not in drifting]
    reduced, described = _rows(sheet, own_times, spans, time, name, raw.columns)
    unit, length = "s" if timed and enough else "rows", f" and {np.ptp(times[good]):.4g} s" * timed
    unused = len(sheet) - sum(int(((own_times >= start) & (own_times < end)).sum()) for start, end in spans)
    reduced.remarks += [
        f"a recording of {len(sheet)} rows{length}: {len(spans)} plateaus; {unused} rows outside are not used",
        *(f"from {grid[start]:.4g} to {grid[end - 1]:.4g} {unit} the channels drift: not used" for start, end in drifting),
        *described,
    ]
    if not spans:
        why = f": in {len(drifting)} stretches the channels drift" if drifting else ""
        text = f"a recording without a plateau of {3 * half * raster:.3g} {unit}{why}; for recorded shifts add a column series"
        text += "; a column step averages the rows of a step; --as-written takes each row as a point" * (not timed)
        reduced.faults.append(Fault(text))
    return reduced


def _rasters(times: Array, channels: Iterable[Array]) -> list[float]:
    """The median time between samples of each channel."""
    return [float(np.median(steps)) for own in channels if len(steps := np.diff(times[np.isfinite(times) & np.isfinite(own)]))]


def _together(count: int, channels: Iterable[Array]) -> Array:
    """Whether each of the rows agrees in all channels with the one above within the scatter of the second differences."""
    found = np.ones(max(count - 1, 1), dtype=bool)
    for values in channels:
        rows = np.flatnonzero(np.isfinite(values))
        if len(rows) > 1:
            own, level = values[rows], np.quantile(np.abs(values[rows]), 0.95)
            scatter = np.median(np.abs(np.diff(own, 2))) / 1.652 if len(own) > 2 else 0.0  # σ √6 · 0.674 for white noise
            limit = min(max(NOISE * scatter, LEAST * level), max(LARGEST * level, NEAR * np.ptp(own)))
            found[rows[1:] - 1] &= np.abs(np.diff(own)) <= limit
    return found


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
    spans = intervals(np.arange(len(steady)), steady)
    return [(int(first) + half, int(last) + 1 + half) for first, last in spans if last + 1 - first >= half]


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
    place = np.full(len(sheet), -1)
    for row, (start, end) in enumerate(spans):
        place[(times >= start) & (times < end)] = row
    inside = place >= 0
    unknown = [title for title, cells in sheet.others.items() if cells.dtype != object]
    data = pd.DataFrame({c: values for c, values in {**sheet.values, **{t: sheet.others[t] for t in unknown}}.items() if c != time})
    groups = data[inside].groupby(place[inside])
    apart = (data[inside] - groups.transform("median")).abs()
    limit = SPIKE * apart.groupby(place[inside]).transform("median")
    spikes = (apart > limit) & (limit > 0.0) & (groups.transform("count") > 2 * SAMPLES)
    kept = data[inside].mask(spikes).groupby(place[inside])
    means, scatter, errors = (found.reindex(range(len(spans))) for found in (kept.mean(), kept.std(), kept.sem()))
    for channel, values in data.items():
        there = np.isfinite(values) & np.isfinite(times)
        if there.sum() > 1:
            # A channel may have a slower raster than the plateaus.
            between = np.interp([0.5 * (start + end) for start, end in spans], times[there], values[there])
            means[channel] = means[channel].fillna(pd.Series(between))
    described, lines = [], [sheet.lines[place == row] for row in range(len(spans))]
    for row, (start, end) in enumerate(spans):
        parts = []
        for channel in channels:
            one, value, size = sheet.taken[channel], means.loc[row, channel], scatter.loc[row, channel]
            spread = f" ± {abs(one.written(value + size) - one.written(value)):.2g}" if np.isfinite(size) else ""
            parts.append(f"{one.title} {one.written(value):.5g}{spread}")
        own = f"lines {lines[row][0]} to {lines[row][-1]}, {len(lines[row])} samples"
        described.append(f"plateau {row + 1}: {start:.4g} to {end:.4g} s, {own}: {'; '.join(parts)}")
    texts = {name: np.array([f"plateau {row}" for row in range(1, len(spans) + 1)], dtype=object)}
    count, first = int(spikes.to_numpy().sum()), np.array([own[0] for own in lines], dtype=int)
    remarks = [*sheet.remarks, *[f"{count} samples far from their plateau are not averaged"] * (count > 0)]
    values, others = ({name: means[name].to_numpy() for name in data if (name in unknown) == which} for which in (False, True))
    of_means = {name: errors[name].to_numpy() for name in values if not name.endswith(DEVIATION)}
    return replace(sheet, values=values, others=others, texts=texts, lines=first, errors=of_means, remarks=remarks), described
