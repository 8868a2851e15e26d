"""Clients' publications: commands that are admitted, and the stops that follow a client's end."""
