"""The bridge's side of the line: what clients send and get, delayed; the service that sets it."""
