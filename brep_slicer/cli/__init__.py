"""The command line: brep-slicer inspect, plan, init, view.

In: words from a shell. Out: files, a few lines on the terminal, an exit code.
"""

from .commands import app, main, run

__all__ = ["app", "main", "run"]
