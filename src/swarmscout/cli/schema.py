"""``swarmscout schema``: what a scenario file may hold, for editors and other programs."""

from __future__ import annotations

__all__ = ["schema"]


def schema() -> None:
    """Print the JSON schema of a scenario: sections, keys, types, ranges, defaults, meanings.

    Editors use it to complete and check scenario files (TOML: the Even Better TOML extension).
    """
    import json

    from swarmscout.mission.scenario import Scenario

    print(json.dumps(Scenario.model_json_schema(), indent=2, ensure_ascii=False))
