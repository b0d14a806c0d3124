"""Proof that the metal is even: step-over measured on the emitted points, coverage, the deposit simulated.

In: a region, beads or a toolpath. Out: figures, and a height map on an unrolled grid.
"""

from .coverage import Coverage, coverage_of
from .deposit import Deposit, Evenness, deposit_of, evenness_of
from .layers import notices_of_proof, proof_of_layers, spacings_in_words, summary_of_proof
from .step_over import StepOver, step_over_of

__all__ = [
    "Coverage",
    "Deposit",
    "Evenness",
    "StepOver",
    "coverage_of",
    "deposit_of",
    "evenness_of",
    "notices_of_proof",
    "proof_of_layers",
    "spacings_in_words",
    "step_over_of",
    "summary_of_proof",
]
