"""Functions that numba compiles."""

from __future__ import annotations

from typing import Any, Callable, TypeVar

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile what Python calls, or load it from the cache."""
    try:
        return njit(error_model="numpy", no_cfunc_wrapper=True, cache=True)(function)
    except RuntimeError:
        # Neither this folder nor the user's cache can be written.
        return njit(error_model="numpy", no_cfunc_wrapper=True)(function)
