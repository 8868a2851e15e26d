"""Helpers of the servers of pages: JSON that is sent to them, and work in other threads."""

from __future__ import annotations

import asyncio
from typing import Any, Callable, Dict

from aiohttp import web

from .plain_data import require_text


async def aside(work: Callable[..., Any], *arguments: Any) -> Any:
    """Do what takes a while in another thread."""
    return await asyncio.get_running_loop().run_in_executor(None, work, *arguments)


async def posted(request: web.Request) -> Any:
    """Return the JSON that was sent.

    Raises
    ------
    aiohttp.web.HTTPException
        It is none: the answer that says so.
    """
    # A page of another site cannot send this type without being asked whether it may.
    if request.content_type != "application/json":
        raise web.HTTPUnsupportedMediaType(text="application/json is needed.\n")
    try:
        content = await request.json()
        require_text(content)
    except (ValueError, LookupError, RecursionError) as error:
        raise web.HTTPBadRequest(text=f"It is no JSON: {error}\n") from error
    return content


async def posted_object(request: web.Request, *keys: str) -> Dict[str, Any]:
    """Return the JSON object that was sent, with no keys but those that are named; see `posted`."""
    content = await posted(request)
    if not isinstance(content, dict) or (keys and not set(content) <= set(keys)):
        wanted = f" of {', '.join(keys)}" if keys else ""
        raise web.HTTPBadRequest(text=f"a JSON object{wanted} is needed\n")
    return content
