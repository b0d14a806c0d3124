"""The command as `python -m brep_slicer.cli`.

In: words from a shell. Out: what `brep-slicer` does.
"""

from . import run

if __name__ == "__main__":
    run()
