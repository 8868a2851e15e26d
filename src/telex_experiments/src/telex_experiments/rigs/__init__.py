"""Rigs of the benchmarks: simulators and browsers of their own, viewers, reports."""
