"""Figures that a repetition adds up: contacts, motion and its smoothness."""
