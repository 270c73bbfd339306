"""Tests of the walker: laws, limits and cited numbers, against independent derivations."""
