"""The experiments that need no scripted operator."""
