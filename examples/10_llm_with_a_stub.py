"""A language model is any object with complete(request) -> Reply: here, one of five lines."""

import json

import swarmscout as ss
from swarmscout.core.language_model import Reply

STEPS = 60


class LastCandidate:
    """Chooses the last candidate of the prompt."""

    def complete(self, request):
        ids = request.schema["properties"]["choice"]["enum"]
        return Reply(json.dumps({"choice": ids[-1], "reason": "the last one"}), model="stub")


run = ss.explore(robots=5, steps=STEPS, destinations="llm-shortlist", model=LastCandidate())
print(run.summary["llm"])
first = run.attempts.row(0, named=True)
print(run.text(first["prompt"])[:400])
print(run.text(first["answer"]))
