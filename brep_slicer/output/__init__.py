"""Plans written down: tables, reports, pictures, CAD wires.

In: a Plan. Out: files, each written whole or not at all.
"""
