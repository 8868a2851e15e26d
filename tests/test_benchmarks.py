"""The benchmarks still fit what they measure."""

from __future__ import annotations

import importlib.machinery
import importlib.util
from pathlib import Path

from telex_control.controller import ControllerState

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


def load(name, monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    loader = importlib.machinery.SourceFileLoader(f"benchmark_{name}", str(BENCHMARKS / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


def test_the_control_benchmark_runs_all_shipped_controllers(monkeypatch):
    control = load("control", monkeypatch)
    urdf, params = control.shipped()
    names = control.controllers_of(params)
    loop = control.local(urdf, params)
    for _ in range(100):
        loop.cycle()
    listed = loop.manager.list_controllers()
    running = [info.name for info, state in listed if state is ControllerState.RUNNING]
    assert sorted(running) == sorted(names)
    assert len(names) > 20
