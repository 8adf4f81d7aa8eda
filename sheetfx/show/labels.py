"""Labels beside points of a plot that keep clear of its curve and of each other."""

from __future__ import annotations

import numpy as np

DISTANCES = (14, 28, 46, 70)
DIRECTIONS = 16
WEIGHT_OF_POINT, WEIGHT_OF_TEXT = 10, 100


def place_labels(axes, texts: list[tuple[float, float, str]], curve: np.ndarray) -> list:
    """Put a text with a thin leader beside each point, where it hides least.

    Parameters
    ----------
    axes : matplotlib axes with their final limits
    texts : x, y and text of each label
    curve : (n, 2), points in data units that labels should not hide
    """
    figure = axes.figure
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    points = axes.transData.transform([(x, y) for x, y, _ in texts]) if texts else np.empty((0, 2))
    to_keep = np.concatenate([axes.transData.transform(curve), *[points] * WEIGHT_OF_POINT])
    taken = [legend.get_window_extent(renderer).extents] if (legend := axes.get_legend()) else []
    frame = axes.get_window_extent(renderer).extents
    scale, labels = figure.dpi / 72, []
    for (x, y, text), point in zip(texts, points, strict=True):
        label = axes.annotate(text, (x, y), xytext=(0, 0), textcoords="offset points", fontsize=9, zorder=5,
                              ha="center", va="center", in_layout=False,
                              arrowprops={"arrowstyle": "-", "lw": 0.6, "color": "#555555", "shrinkB": 4})
        box = label.get_window_extent(renderer)
        half = np.array([box.width, box.height]) / 2 + 2 * scale
        offsets = [np.array([np.cos(a), np.sin(a)]) * (half + distance * scale)
                   for distance in DISTANCES for a in np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False)]
        costs = [_cost(point, offset, half, to_keep, taken, frame) for offset in offsets]
        offset = offsets[int(np.argmin(costs))]
        label.set_position(offset / scale)
        taken.append(np.concatenate([point + offset - half, point + offset + half]))
        to_keep = np.concatenate([to_keep, _leader(point, offset)])
        labels.append(label)
    return labels


def _leader(point: np.ndarray, offset: np.ndarray) -> np.ndarray:
    return point + np.linspace(0.1, 0.9, 15)[:, None] * offset


def _cost(point, offset, half, to_keep: np.ndarray, taken: list[np.ndarray], frame: np.ndarray) -> float:
    """How much a label and its leader hide, how far it leaves the frame and how long the leader is (pixels)."""
    box = np.concatenate([point + offset - half, point + offset + half])
    hidden = _inside(to_keep, box)
    overlaps = sum(bool((box[:2] < other[2:]).all() and (other[:2] < box[2:]).all()) for other in taken)
    crossed = sum(_inside(_leader(point, offset), other) for other in taken)
    outside = np.maximum(frame[:2] - box[:2], 0).sum() + np.maximum(box[2:] - frame[2:], 0).sum()
    return hidden + WEIGHT_OF_TEXT * (overlaps + crossed) + outside + 0.02 * float(np.linalg.norm(offset))


def _inside(points: np.ndarray, box: np.ndarray) -> int:
    return int(((points > box[:2]) & (points < box[2:])).all(axis=1).sum())
