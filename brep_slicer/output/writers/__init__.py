"""The writers, a module each, found by being here: a module's name is its writer's.

In: a plan. Out: files.
"""

from brep_slicer.extensions import Extensions

WRITERS = Extensions(
    kind="writer", folder="output/writers", group="brep_slicer.writers", base="brep_slicer.output.writer:Writer"
)

__all__ = ["WRITERS"]
