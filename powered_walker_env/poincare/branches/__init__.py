"""Gaits along parameters: continuation, special points, cascades, boundaries, ramps."""
