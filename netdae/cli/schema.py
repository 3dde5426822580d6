"""`netdae schema`: the JSON schema of a scenario, for editors."""

from __future__ import annotations


def schema() -> None:
    """Print the JSON schema of a scenario file."""
    import json

    from netdae.scenario.schema import ScenarioData

    found = {"$schema": "https://json-schema.org/draft/2020-12/schema", **ScenarioData.model_json_schema()}
    print(json.dumps(found | {"title": "netdae scenario"}, indent=2))  # ASCII, right in any encoding
