"""Settings of the property tests: compilation makes first examples slow, and a run in CI must be repeatable."""

from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")
