"""Experiments with the simulator: programs over the product, neither product nor test."""
