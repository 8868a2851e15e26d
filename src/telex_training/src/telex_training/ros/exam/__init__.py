"""What makes a trial an exam: the list that the bridge holds while it runs."""
