"""The axis and the cylinder that is built on: found from the part's own faces, or given."""

from .axis import Axis, axis_candidates, axis_from_line, axis_from_text, find_axis

__all__ = ["Axis", "axis_candidates", "axis_from_line", "axis_from_text", "find_axis"]
