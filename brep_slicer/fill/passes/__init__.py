"""What is done to the beads of a layer after its patterns laid them: starts, speeds, order, rest.

In: the beads of a layer. Out: the same beads.
"""
