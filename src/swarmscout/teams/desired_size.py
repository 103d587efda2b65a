"""Desired team sizes: a policy is called once per step, for all robots."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.errors import PolicyError
from swarmscout.core.jit import kernel
from swarmscout.core.tracebacks import describe_error
from swarmscout.minds.minds import Minds
from swarmscout.minds.modes import is_on_task
from swarmscout.teams.policy import LARGEST, DesiredSizePolicy
from swarmscout.teams.robots_view import RobotsView

__all__ = ["DesiredSizes", "checked_sizes"]


@kernel
def take_sizes(own, answer, largest):  # type: ignore[no-untyped-def]
    """Write desired sizes into minds; in CHR mode it is 1.

    Args:
        own: MIND[N]; answer: int64[N]; largest: how many are possible.

    Returns:
        The first robot whose answer is impossible, or -1.
    """
    for i in range(own.shape[0]):
        if answer[i] < 1 or answer[i] > largest:
            return i
        own[i].desired = answer[i] if is_on_task(own[i].mode) else 1
    return -1


class DesiredSizes:
    """Calls the policy.

    Args:
        policy: sets the sizes.
        name: its name in errors.
        desired_size: the scenario's ``teams.desired_size``, also the size before the first step.
        silence_steps: a robot that was not heard for more steps than this counts no more.
    """

    def __init__(
        self, policy: DesiredSizePolicy, name: str, desired_size: int, silence_steps: int
    ) -> None:
        self.policy = policy
        self.name = name
        self.desired_size = desired_size
        self._silence_steps = silence_steps

    def decide(self, minds: Minds, knowledge: Knowledge, step: int) -> None:
        """Write the team size that each robot desires into its mind.

        Raises:
            PolicyError: the policy failed, or did not answer a size for each robot.
        """
        view = RobotsView(minds, knowledge, step, self.desired_size, self._silence_steps)
        try:
            answer = self.policy.desired(view)
        except (Exception, SystemExit) as error:
            raise PolicyError(
                f"policy '{self.name}' failed in step {step}: {describe_error(error)}"
            ) from error
        try:
            sizes = checked_sizes(answer, len(view))
            wrong = int(take_sizes(minds.own, sizes, LARGEST))
        except PolicyError as error:
            raise PolicyError(f"policy '{self.name}' {error} (step {step})") from None
        if wrong >= 0:
            raise PolicyError(
                f"policy '{self.name}' answered {sizes[wrong]} for robot {wrong} in step {step}: "
                f"expected 1 to {LARGEST:,}"
            )


def checked_sizes(answer: Any, robots: int) -> NDArray[np.int64]:
    """An answer as whole numbers, one for each robot.

    Args:
        answer: what a policy returned.
        robots: N.

    Raises:
        PolicyError: it is something else; the message begins with a verb.
    """
    if isinstance(answer, np.ndarray) and answer.dtype == np.int64 and answer.shape == (robots,):
        return np.ascontiguousarray(answer)
    try:
        sizes = np.asarray(answer)
    except ValueError:  # Rows of different lengths.
        sizes = np.asarray(None)
    if sizes.shape == (robots,) and sizes.dtype.kind in "iu":
        return sizes.astype(np.int64)
    shape = list(sizes.shape)
    what = type(answer).__name__ if sizes.dtype.kind == "O" else f"{sizes.dtype}{shape}"
    hint = ""
    if sizes.shape == (robots,) and sizes.dtype.kind == "f":
        hint = "; sizes are whole numbers: np.rint(…).astype(int)"
    elif answer is not None and sizes.shape == ():
        hint = f"; the same for all is np.full(len(view), {sizes})"
    what = "None" if answer is None else what
    raise PolicyError(f"returned {what}, expected int64[{robots}], a size for each robot{hint}")
