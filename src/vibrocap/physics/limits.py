"""A limit of a value, reached in front and behind, as numbers and guards that never branch on a value."""

from typing import Any

HELD_AFTER = (1.0, 0.0, -1.0)  # what `held` is after each of these guards


def limited(held, value, limit) -> Any:
    """A value behind a limit: `held` is +1 or -1 where the limit holds, 0 where it does not."""
    return (1.0 - held * held) * value + held * limit


def limit_guards(held, value, asked, limit) -> tuple:
    """Guards of such a limit: it is reached in front, left, reached behind; asked: what has to come back."""
    at, free = held * held, 1.0 - held * held
    return (
        at + free * (limit - value) / limit,
        free + (held * asked - at * limit) / limit,
        at + free * (limit + value) / limit,
    )
