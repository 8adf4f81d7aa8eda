"""A state that another number of processes has kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ..continuation.state import State


@dataclass(frozen=True)
class ScatteredState(State):
    """A state whose arrays belong to another distribution of the meshes.

    Attributes
    ----------
    parts : of each process that kept it
    origins : of the rows of their arrays, see `System.origins`
    """

    parts: Sequence[State] = ()
    origins: Sequence[Mapping[str, np.ndarray]] = ()

    @classmethod
    def of(cls, parts: Sequence[State], origins: Sequence[Mapping[str, np.ndarray]]) -> ScatteredState:
        """From the parts of all processes."""
        return cls(**{f.name: getattr(parts[0], f.name) for f in fields(State)}, parts=parts, origins=origins)

    def taken(self, wanted: Mapping[str, np.ndarray]) -> State:
        """The state as this process has it.

        Parameters
        ----------
        wanted : origins of the rows of this process

        Raises
        ------
        ValueError
            If one of its arrays does not say what its rows belong to.
        """
        unknown = [name for name in self.fields if name not in wanted or name not in self.origins[0]]
        if unknown:
            raise ValueError(f"--resume: states of {len(self.parts)} processes do not say which points {unknown[0]!r} "
                             f"belongs to; start with mpirun -n {len(self.parts)}")
        values = {name: self._collected(name, [p.fields[name] for p in self.parts], wanted) for name in self.fields}
        vectors = {name: self._collected("increment", [getattr(p, name) for p in self.parts], wanted)
                   for name in ("increment", "response")}
        return replace(State(**{f.name: getattr(self, f.name) for f in fields(State)}), fields=values, **vectors)

    def _collected(self, name: str, values: Sequence[np.ndarray], wanted: Mapping[str, np.ndarray]) -> np.ndarray:
        """An array of this process from the others'; flat where theirs are."""
        parts = [(origins[name], array) for origins, array in zip(self.origins, values, strict=True)]
        found = _collected(parts, wanted[name])
        return found if values[0].ndim > 1 else found.ravel()


def _collected(parts: list[tuple[np.ndarray, np.ndarray]], wanted: np.ndarray) -> np.ndarray:
    """Rows with given origins.

    Parameters
    ----------
    parts : origins of the rows of each process and their values, in arrays that may be flat
    wanted : origins of the rows that are asked for

    Returns
    -------
    array, shape (wanted, ...) where the parts are not flat, else (wanted, values of a row)

    Raises
    ------
    KeyError
        If no part has one.
    """
    known, first = np.unique(np.concatenate([origins for origins, _ in parts]), return_index=True)
    if not len(known):
        return np.empty(0)
    place = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    if (known[place] != wanted).any():
        raise KeyError("rows that no process has kept")
    kept = [values.reshape(len(origins), *(values.shape[1:] if values.ndim > 1 else (-1,)))
            for origins, values in parts if len(origins)]
    return np.concatenate(kept)[first[place]]
