"""Exams: what is left to trainees while one runs."""
