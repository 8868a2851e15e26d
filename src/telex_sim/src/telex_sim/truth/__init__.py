"""Ground truth of a robot and its surroundings, for scoring and for drawing it again."""
