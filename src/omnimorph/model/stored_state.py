"""What is stored, copied and pickled in the middle of a flight, and goes on the same."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Protocol

from omnimorph.errors import ScenarioError


class _CorePart(Protocol):
    """A part of the compiled core that remembers something."""

    def store(self) -> bytes: ...

    def restore(self, state: bytes) -> None: ...


class Storable:
    """A part of a flight whose memory lies in the compiled core.

    Attributes
    ----------
    kind : str
        What messages call it.
    """

    kind: ClassVar[str]
    _in_core: _CorePart

    def stored_state(self) -> bytes:
        """Return what it remembers: all that it needs to go on the same to the last bit.

        What it was made of is not part of it.
        """
        return self._in_core.store()

    def restore(self, state: bytes) -> None:
        """Go on from what one like it has stored; of another mass or noise, with its own.

        Raises
        ------
        ScenarioError
            If the state is of another version of omnimorph, of something else, of other counts of
            rotors and servos, another delay or other time steps, or broken.
        """
        try:
            self._in_core.restore(memoryview(state).tobytes())
        except (TypeError, ValueError) as problem:
            place = f"the state of the {self.kind}"
            allowed = f"what a {self.kind} like it has stored"
            raise ScenarioError(
                f"{place} cannot be used, because {problem}; it must be {allowed}."
            ) from None


class Copyable(Storable, ABC):
    """One that is copied and pickled too, and needs nothing for it but what it is made of."""

    @abstractmethod
    def _new_core(self) -> Any:
        """Return a part of the core of the same settings; what it remembers does not matter."""

    def __getstate__(self) -> dict[str, Any]:
        """Return what it is made of and what it remembers."""
        return vars(self) | {"_in_core": self.stored_state()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Become one that was copied or pickled."""
        vars(self).update(state)
        self._in_core = self._new_core()
        self.restore(state["_in_core"])
