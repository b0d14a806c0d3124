"""What patterns and passes are made of: offsets, scan lines, the medial axis, distances.

In: pieces, lines. Out: plain geometry in the plane.
"""
