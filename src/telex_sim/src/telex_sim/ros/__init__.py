"""The simulator's nodes, services and messages."""
