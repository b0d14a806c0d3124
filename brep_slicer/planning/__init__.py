"""From a part and a process to a plan: the stages strung together, and what there is to warn of.

In: a part, a Process. Out: a Plan. No geometry here.
"""

from .planned import Plan, PlanSections
from .planner import fill_layers, motion_of, plan
from .sections import check_complete, cut_layers

__all__ = ["Plan", "PlanSections", "check_complete", "cut_layers", "fill_layers", "motion_of", "plan"]
