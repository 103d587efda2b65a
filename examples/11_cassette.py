"""Record the replies of a language model, and run the same mission again without the model."""

import json
import tempfile
from pathlib import Path

import swarmscout as ss
from swarmscout.core.language_model import Reply

STEPS = 60


class FirstCandidate:
    """Stands for any provider: see docs/llm.md for real ones."""

    def complete(self, request):
        ids = request.schema["properties"]["choice"]["enum"]
        return Reply(json.dumps({"choice": ids[0], "reason": "the first one"}), model="stub")


with tempfile.TemporaryDirectory() as folder:
    cassette = Path(folder) / "replies.jsonl"
    keys = {"robots": 5, "steps": STEPS, "destinations": "llm-shortlist"}
    recorded = ss.explore(
        **keys, model=FirstCandidate(), llm={"cassette": str(cassette), "mode": "record"}
    )
    print(f"{len(cassette.read_text('utf-8').splitlines())} lines on the cassette")
    replayed = ss.explore(**keys, llm={"cassette": str(cassette), "mode": "replay"})

assert replayed.steps.equals(recorded.steps)
print("the replayed mission is the same, step by step")
