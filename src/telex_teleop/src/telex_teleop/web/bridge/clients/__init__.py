"""What a client is: what it may do, whether it has control, and what goes to it."""
