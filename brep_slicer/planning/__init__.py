"""From a part and a process to a plan: the stages strung together, and what there is to warn of.

In: a part, a Process. Out: a Plan. No geometry here.
"""

from .planner import Plan, check_complete, motion_of, plan

__all__ = ["Plan", "check_complete", "motion_of", "plan"]
