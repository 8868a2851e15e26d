"""Services that clients call and offer, and the goals of actions."""
