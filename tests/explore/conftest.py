"""Pictures of fewer points, for tests of many walkers; one walker has them whole."""

from __future__ import annotations

import pytest

from powered_walker_env.explore import views


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, number in {"POINTS": 36, "VALUES": 21, "TRANSIENT": 60, "KEPT": 8}.items():
        assert getattr(views, name) > number
        monkeypatch.setattr(views, name, number)
