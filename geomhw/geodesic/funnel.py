"""Shortest path within a strip of faces, by the funnel algorithm in the plane of the unfolded strip.

A strip is the sequence of edges that a path crosses: ``leave`` and ``enter``, the halfedges of the faces before and
after each edge.

Lee, Preparata: Euclidean Shortest Paths in the Presence of Rectilinear Barriers. Networks 14(3), 1984.
"""

from math import sqrt

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.unfolded_faces import Surface, ends, triangle

#: A path crosses an edge at its end if it is nearer, as a share of the edge.
AT_END = 1e-12


@compiled_in_place
def shortest_in_strip(
    surface: Surface, leave: Ints, enter: Ints, start: Floats, end: Floats, gates: Floats, bends: Ints, shares: Floats
) -> float:
    """Find the shortest path within a strip of k ≥ 1 edges, and return its length.

    Parameters
    ----------
    start, end : (3,) arrays, barycentric coordinates in the first and the last face.
    gates : (k + 2, 4) array, workspace.
    bends : (k,) integer array
        Takes the vertex at which the path crosses each edge and turns, or -1.
    shares : (k,) array
        Takes the place where the path crosses each edge, as the share of the edge from its lower vertex.
    """
    _unfold(surface, leave, enter, start, end, gates)
    bends[:] = 0
    k = len(leave)
    ax, ay, begin = gates[0, 0], gates[0, 1], 0
    length, total = 0.0, 0.0
    while begin <= k:
        # The funnel from the apex (ax, ay), which lies before gate begin + 1.
        left = right = begin
        lx, ly, rx, ry = ax, ay, ax, ay
        stop = turn = 0
        for i in range(begin + 1, k + 2):
            px, py, qx, qy = gates[i, 0], gates[i, 1], gates[i, 2], gates[i, 3]
            if i > k:  # the end
                if _cross(lx - ax, ly - ay, px - ax, py - ay) > 0:
                    stop, turn = left, 1
                elif _cross(rx - ax, ry - ay, px - ax, py - ay) < 0:
                    stop, turn = right, -1
                break
            if _cross(rx - ax, ry - ay, qx - ax, qy - ay) >= 0:
                if _cross(lx - ax, ly - ay, qx - ax, qy - ay) > 0 and not (rx == ax and ry == ay):
                    stop, turn = left, 1
                    break
                right, rx, ry = i, qx, qy
            if _cross(lx - ax, ly - ay, px - ax, py - ay) <= 0:
                if _cross(rx - ax, ry - ay, px - ax, py - ay) < 0 and not (lx == ax and ly == ay):
                    stop, turn = right, -1
                    break
                left, lx, ly = i, px, py
        if turn == 0:
            stop, bx, by = k + 1, gates[k + 1, 0], gates[k + 1, 1]
        elif turn > 0:
            bx, by = lx, ly
        else:
            bx, by = rx, ry
        for i in range(begin + 1, min(stop, k) + 1):
            shares[i - 1] = _crossing(gates[i], ax, ay, bx, by)
        length = sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        total += length
        if turn == 0:
            break
        ax, ay, begin = bx, by, stop
        # All edges in a row that end at the vertex are crossed there.
        column = 0 if turn > 0 else 2
        first = stop
        while first > 1 and gates[first - 1, column] == bx and gates[first - 1, column + 1] == by:
            first -= 1
        while begin < k and gates[begin + 1, column] == bx and gates[begin + 1, column + 1] == by:
            begin += 1
        for i in range(first, begin + 1):
            shares[i - 1] = 0.0 if turn > 0 else 1.0
            bends[i - 1] = turn
    _to_mesh(surface, leave, enter, bends, shares)
    return total


@compiled_in_place
def _cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


@compiled_in_place
def _unfold(surface: Surface, leave: Ints, enter: Ints, start: Floats, end: Floats, gates: Floats) -> None:
    """Lay out the strip: gate i + 1 takes the left and the right end of edge i; the first and last, start and end."""
    k = len(leave)
    face = triangle(surface, leave[0])
    # The first face lies below its edge, the path goes up: the lower vertex is on the left.
    x, y, at_left = face.left * face.cos_low, -face.left * face.sin_low, face.low
    gates[0, 0], gates[0, 1] = 0.0, 0.0
    f = leave[0] // 3
    for c in range(3):
        v = surface.faces[f, c]
        px, py = (0.0, 0.0) if v == face.low else (face.base, 0.0) if v == face.high else (x, y)
        gates[0, 0] += start[c] * px
        gates[0, 1] += start[c] * py
    gates[0, 2], gates[0, 3] = gates[0, 0], gates[0, 1]
    lx, ly, rx, ry = 0.0, 0.0, face.base, 0.0
    for i in range(k):
        gates[i + 1, 0], gates[i + 1, 1], gates[i + 1, 2], gates[i + 1, 3] = lx, ly, rx, ry
        face = triangle(surface, enter[i])
        base = sqrt((rx - lx) ** 2 + (ry - ly) ** 2)
        ex, ey = ((rx - lx) / base, (ry - ly) / base) if base > 0 else (1.0, 0.0)
        low_left = face.low == at_left
        along, up = face.left * face.cos_low, face.left * face.sin_low
        if low_left:
            x, y = lx + along * ex - up * ey, ly + along * ey + up * ex
        else:
            x, y = rx - along * ex - up * ey, ry - along * ey + up * ex
        if i + 1 < k:
            if (leave[i + 1] == face.at_low) == low_left:
                rx, ry = x, y
            else:
                lx, ly, at_left = x, y, face.apex
    f = enter[k - 1] // 3
    ex, ey = 0.0, 0.0
    for c in range(3):
        v = surface.faces[f, c]
        px, py = (x, y) if v == face.apex else (lx, ly) if v == at_left else (rx, ry)
        ex += end[c] * px
        ey += end[c] * py
    gates[k + 1, 0], gates[k + 1, 1], gates[k + 1, 2], gates[k + 1, 3] = ex, ey, ex, ey


@compiled_in_place
def _crossing(gate: Floats, ax: float, ay: float, bx: float, by: float) -> float:
    """Share of a gate, from its left end, at which the line from a to b crosses it."""
    lx, ly, dx, dy = gate[0], gate[1], gate[2] - gate[0], gate[3] - gate[1]
    from_left = _cross(bx - ax, by - ay, lx - ax, ly - ay)
    from_right = _cross(bx - ax, by - ay, lx + dx - ax, ly + dy - ay)
    if from_left == from_right:  # the line runs along the gate
        return 0.0 if (lx - bx) ** 2 + (ly - by) ** 2 < (lx + dx - bx) ** 2 + (ly + dy - by) ** 2 else 1.0
    return min(max(from_left / (from_left - from_right), 0.0), 1.0)


@compiled_in_place
def _to_mesh(surface: Surface, leave: Ints, enter: Ints, bends: Ints, shares: Floats) -> None:
    """Replace shares from the left by shares from the lower vertex, and sides of turns by vertices."""
    at_left = ends(surface, leave[0])[0]
    for i in range(len(leave)):
        low, high = ends(surface, leave[i])
        bends[i] = -1 if bends[i] == 0 else at_left if bends[i] > 0 else low + high - at_left
        if at_left != low:
            shares[i] = 1.0 - shares[i]
        if shares[i] < AT_END:
            shares[i] = 0.0
        elif shares[i] > 1 - AT_END:
            shares[i] = 1.0
        if i + 1 < len(leave):
            face = triangle(surface, enter[i])
            if (leave[i + 1] == face.at_low) != (at_left == face.low):
                at_left = face.apex
