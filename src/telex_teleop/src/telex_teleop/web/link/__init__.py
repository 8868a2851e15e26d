"""Messages on the line in an asyncio server; the line itself, without a clock, is `web.line`."""
