"""Solid and cylinder, cut: exact closed loops, layer by layer, each with a certificate."""

from .layer import Certificate, Engine, FailedLayer, Layer

__all__ = ["Certificate", "Engine", "FailedLayer", "Layer"]
