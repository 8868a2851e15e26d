"""Clients' subscriptions."""
