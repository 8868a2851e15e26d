"""Recordings of trials: one MCAP file each, the only thing that is judged."""
