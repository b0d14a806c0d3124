"""Benchmarks: ratios to a stated base in the same run."""
