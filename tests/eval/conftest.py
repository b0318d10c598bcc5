"""What the tests of commands share."""

from types import SimpleNamespace

import pytest

from eval.kept import entries


@pytest.fixture
def plays(monkeypatch):
    """Names and first seeds of what is really played, in order; may be told at which one to fail, and how.

    Nothing is played once more to be looked at.
    """
    state = SimpleNamespace(names=[], seeds=[], fail_at=None, error=KeyboardInterrupt())
    original = entries.play

    def counted(agent, **kwargs):
        if len(state.names) == state.fail_at:
            raise state.error
        state.names.append(agent.name)
        state.seeds.append(kwargs["seed"])
        return original(agent, **kwargs)

    monkeypatch.setattr(entries, "play", counted)
    monkeypatch.setattr("eval.comparison.motion.play_patient", lambda study, *given, **more: study)
    return state
