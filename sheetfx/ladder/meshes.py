"""Cases of one structure on ever finer meshes."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..critical.remade import Remade
from ..model.richer import NothingRicher, finer, richer

if TYPE_CHECKING:
    from ..case import Case

OPTIONS = "cells", "elements", "divisions"  # of scenes, that their meshes are made by
FEWEST = 4  # cells that are not halved in number
ALIKE = 0.05  # difference of lengths, areas and sizes on other cells of one structure


@dataclass(frozen=True)
class Meshes:
    """Cases by level: 0 as the scene is given, with cells of half the size one level up.

    Attributes
    ----------
    case : function from a level to the case
    words : function from a level to what messages call its mesh
    lowest, highest : levels that there are
    made : function from a level to the expression that makes it from `case`, in a script; options of the scene apart
    options : function from a level to the options of the scene that make its cells
    """

    case: Callable[[int], Case]
    words: Callable[[int], str]
    lowest: int = 0
    highest: int = 1
    made: Callable[[int], str] = lambda level: "case"
    options: Callable[[int], dict[str, Any]] = lambda level: {}


def by_option(function: Callable[..., Case], parameters: Mapping[str, Any], finest: int = 1,
              refine: str | None = None) -> Meshes | None:
    """Meshes by an option of a scene: numbers of cells (integers), or their size (a float).

    None where there is no such option, or where one that is not named makes another structure.

    Parameters
    ----------
    refine : the option; None: the first of OPTIONS that the scene has

    Raises
    ------
    ValueError
        If the scene has not the option `refine`, it is no number, or it makes another structure.
    """
    options = inspect.signature(function, eval_str=True).parameters
    if refine is not None and refine.replace("-", "_") not in options:
        raise ValueError(f"--refine is {refine!r}, but the scene has no such option; it has {', '.join(options)}")
    name = refine.replace("-", "_") if refine else next((name for name in OPTIONS if name in options), None)
    given = parameters.get(name, options[name].default) if name else None
    numbers = given if isinstance(given, (tuple, list)) else [given]
    if not all(type(n) in (int, float) for n in numbers):
        if refine:
            raise ValueError(f"--refine {refine}: the option is {given!r}; name one that is a number")
        return None

    def at(level: int) -> dict[str, Any]:
        found = [max(1, round(n * 2.0**level)) if isinstance(n, int) else n / 2.0**level for n in numbers]
        return {name: type(given)(found) if isinstance(given, (tuple, list)) else found[0]}

    def case(level: int) -> Case:
        return function(**{**parameters, **at(level)})

    def words(level: int) -> str:
        found = at(level)[name]
        return f"{name} {found if isinstance(found, (int, float)) else ' x '.join(map(str, found))}"

    few = min((n for n in numbers if isinstance(n, int)), default=FEWEST) < FEWEST
    try:
        other = case(1 if few else -1)
    except ValueError:
        return Meshes(case, words, 0, finest, options=at)
    if not _same_structure(case(0), other):
        if refine:
            raise ValueError(f"--refine {refine}: {words(1 if few else -1)} makes another structure, of other lengths "
                             "or areas; name an option that makes its cells")
        return None
    return Meshes(case, words, 0 if few else -1, finest, options=at)


def _same_structure(one: Case, other: Case) -> bool:
    """Whether two cases have parts of the same size and, but for curved cells, of the same lengths and areas."""
    pairs = list(zip(one.scene.meshes, other.scene.meshes, strict=False))
    return len(one.scene.meshes) == len(other.scene.meshes) and all(
        abs(a.measure - b.measure) <= ALIKE * a.measure and abs(a.size - b.size) <= ALIKE * a.size for a, b in pairs)


def by_halving(case: Case, finest: int = 1) -> Meshes:
    """Meshes of a case whose cells gmsh divides, or where it cannot, with one degree more one level up."""
    try:
        if finest:
            finer(case.scene.parts)
    except NothingRicher:
        return _by_degree(case)

    def words(level: int) -> str:
        return "the given mesh" if not level else f"the given mesh with cells of 1/{2**level} of the size"

    return Meshes(lambda level: halved(case, level), words, 0, finest,
                  lambda level: f"fx.halved(case, {level})" if level else "case")


def _by_degree(case: Case) -> Meshes:
    """The given mesh, and with polynomials of one degree more where these are known."""
    try:
        raised(case)
    except NothingRicher:
        highest = 0
    else:
        highest = 1
    return Meshes(lambda level: raised(case) if level else case,
                  lambda level: "the given mesh" + (" with one degree more" if level else ""), 0, highest,
                  lambda level: "fx.raised(case)" if level else "case")


def halved(case: Case, times: int = 1) -> Case:
    """A case whose cells gmsh divides in two along each side; without its events, which may look at its meshes.

    Raises
    ------
    NothingRicher
        Where gmsh does not know what the cells are on.
    """
    return _with(case, finer(case.scene.parts, times)) if times else case


def raised(case: Case) -> Case:
    """A case with polynomials of one degree more on the same cells, without its events, as `halved`.

    Raises
    ------
    NothingRicher
        Where there is none.
    """
    return _with(case, richer(case.scene.parts))


def _with(case: Case, new: Mapping[Any, Any]) -> Case:
    scene, control = Remade({id(one): other for one, other in new.items()}).of((case.scene, case.control))
    return replace(case, scene=scene, control=control, events=(), until=replace(case.until, event=None))
