"""Check a selector of your own against its contract: a test for your test suite."""

import swarmscout as ss
from swarmscout.destinations.selector import Choice
from swarmscout.testing import check_selector


class Greedy:
    """The nearest frontier by route."""

    def choose(self, view, memory):
        row, col = view.frontiers[view.route_costs().argmin()].tolist()
        return Choice((row, col))


class Forgetful(Greedy):
    """Breaks the contract: it keeps its memory in itself."""

    asked = 0

    def choose(self, view, memory):
        self.asked += 1
        return super().choose(view, memory)


print(check_selector(Greedy()))
try:
    check_selector(Forgetful())
except ss.SelectorError as error:
    print(f"refused: {error}")
