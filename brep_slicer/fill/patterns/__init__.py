"""The patterns, a module each, found by being here: a module's name is its pattern's.

In: areas. Out: beads.
"""
