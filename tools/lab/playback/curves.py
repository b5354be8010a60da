# SPDX-License-Identifier: Apache-2.0
"""Interpolates curves of error over compression, and draws them."""
import html
import math

COLOURS = (("#1b6ca8", "#6db6ee"), ("#b35900", "#f0a35a"), ("#287d3c", "#78c98a"), ("#8a3fa0", "#cf95e2"))
DASHES = ("none", "7 4", "2 3")
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 820, 430, 56, 262, 20, 44


def value_at(points, ratio):
    """Interpolates the error at a ratio between neighbouring points, with both axes logarithmic. `points` are (ratio,
    error) in any order. Returns None beyond the ends of the curve."""
    points = sorted(points)
    for (left, low), (right, high) in zip(points, points[1:]):
        if left <= ratio <= right:
            share = math.log(ratio / left) / math.log(right / left) if right > left else 0.0
            return math.exp(math.log(low) + share * math.log(high / low))
    # An encoder can produce a slightly smaller file than requested, so a curve can begin slightly beyond `ratio`. In
    # this case, the error of the first point is an upper bound.
    near = [error for at, error in points if 1 <= at / ratio < 1.05]
    return near[0] if near else None


def ticks(least, most):
    return [m * 10 ** p for p in range(-2, 6) for m in (1, 2, 5) if least <= m * 10 ** p <= most]


def apart(places, distance):
    """Moves places so that neighbours are at least `distance` apart, and keeps their order."""
    order = sorted(range(len(places)), key=lambda i: places[i])
    moved, last = list(places), -math.inf
    for i in order:
        moved[i] = last = max(places[i], last + distance)
    return moved


def picture(title, curves, marks):
    """Draws a self-contained SVG for light and dark pages. `curves` are (name, colour number, dash number, points
    (ratio, error)). `marks` are ratios that are marked by a line."""
    curves = [one for one in curves if one[3]]
    ratios = [ratio for *_, points in curves for ratio, _ in points]
    errors = [error for *_, points in curves for _, error in points]
    least_x, most_x = min(ratios + list(marks)) / 1.05, max(marks) * 1.35
    shown = [error for *_, points in curves for ratio, error in points if least_x <= ratio <= most_x]
    shown += [at for at in (value_at(points, most_x) for *_, points in curves) if at]
    shown = shown or errors
    least_y, most_y = min(shown) / 1.1, max(shown) * 1.1
    x_of = lambda r: LEFT + (WIDTH - LEFT - RIGHT) * math.log(r / least_x) / math.log(most_x / least_x)
    y_of = lambda e: HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * math.log(e / least_y) / math.log(most_y / least_y)
    light = " ".join(f".c{i} {{ --c: {colour}; }}" for i, (colour, _) in enumerate(COLOURS))
    dark = " ".join(f".c{i} {{ --c: {colour}; }}" for i, (_, colour) in enumerate(COLOURS))
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
           f'role="img"><title>{html.escape(title)}</title><style>'
           f".back {{ fill: #fdfdfb; }} text {{ fill: #5b6670; font: 13px system-ui, sans-serif; }} "
           f".line {{ stroke: #d5d9dc; }} .mark {{ stroke: #9aa4ab; }} {light} "
           "polyline { fill: none; stroke: var(--c); stroke-width: 2; } circle { fill: var(--c); } "
           ".name { fill: var(--c); } @media (prefers-color-scheme: dark) { .back { fill: #15191d; } "
           f"text {{ fill: #a0abb4; }} .line {{ stroke: #39424a; }} .mark {{ stroke: #6b757d; }} {dark} }}</style>"
           f'<rect class="back" width="{WIDTH}" height="{HEIGHT}"/>']
    right = WIDTH - RIGHT
    for error in ticks(least_y, most_y):
        y = y_of(error)
        out.append(f'<line class="line" x1="{LEFT}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}"/>'
                   f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{error:g}</text>')
    for ratio in marks:
        x = x_of(ratio)
        out.append(f'<line class="mark" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>'
                   f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 17}" text-anchor="middle">{ratio:g}:1</text>')
    out.append(f'<text x="{(LEFT + right) / 2}" y="{HEIGHT - 6}" text-anchor="middle">raw frames over what is stored'
               f'</text><text x="4" y="12">MSE</text>'
               f'<clipPath id="plot"><rect x="{LEFT}" y="{TOP}" width="{right - LEFT}" '
               f'height="{HEIGHT - TOP - BOTTOM}"/></clipPath>')
    ends = []
    for name, colour, dash, points in curves:
        points = sorted(points)
        line = " ".join(f"{x_of(r):.1f},{y_of(e):.1f}" for r, e in points)
        dots = "".join(f'<circle cx="{x_of(r):.1f}" cy="{y_of(e):.1f}" r="3"><title>{html.escape(name)}, {r:.0f}:1: '
                       f"{e:.1f}</title></circle>" for r, e in points)
        out.append(f'<g class="c{colour}" clip-path="url(#plot)"><polyline points="{line}" '
                   f'stroke-dasharray="{DASHES[dash]}"/>{dots}</g>')
        end = max(least_y, min(most_y, value_at(points, most_x) or points[-1][1]))
        ends.append((name, colour, dash, y_of(end)))
    for (name, colour, dash, _), y in zip(ends, apart([one[3] for one in ends], 17)):
        out.append(f'<g class="c{colour}"><polyline points="{right + 6},{y:.1f} {right + 30},{y:.1f}" '
                   f'stroke-dasharray="{DASHES[dash]}"/>'
                   f'<text class="name" x="{right + 35}" y="{y + 4:.1f}">{html.escape(name)}</text></g>')
    return "".join(out) + "</svg>\n"
