"""The list that the bridge holds while an exam runs."""
