"""The objects that scene files name by their type."""
