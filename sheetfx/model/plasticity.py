"""Plastic materials, and section laws that integrate them through the thickness or over fibres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

import numba
import numpy as np

from ..checks import NotNegative, Positive
from ..forms.section import linear_elastic, linear_shell
from ..notices import warn
from .history import LawWithHistory
from .plastic_energy import fibre_energies, layer_energies
from .plate import Plate
from .return_mapping import ON_SURFACE, REMEMBERED, one_axis, plane_stress
from .section import Elastic

SHEARED = 0.1  # square of shear and torsion over what a section carries of them alone, from which on they count


@dataclass(frozen=True)
class Plastic(Elastic):
    """Elastic-plastic material with von Mises's yield condition and linear hardening.

    Attributes
    ----------
    yield_stress : in tension (force / length^2)
    hardening : increase of the yield stress by plastic strain in one axis (isotropic); the slope of the stress-strain
        curve is then E H / (E + H). Negative: softening, of beams and bars only
    kinematic : increase of the back stress by plastic strain in one axis, likewise
    """

    yield_stress: Positive = 0.0
    hardening: float = 0.0
    kinematic: NotNegative = 0.0

    def __post_init__(self):
        super().__post_init__()
        if self.hardening + self.kinematic <= -self.modulus:
            raise ValueError(f"Plastic: hardening + kinematic is {self.hardening + self.kinematic}, at or below minus "
                             f"the modulus {self.modulus}: stress would jump; give a slower softening")


def section_law(law: Callable, section, material: Elastic, stiffness):
    """The law of a part: as it is, or where it is not the user's and the material is plastic that of the section.

    Parameters
    ----------
    law : given to the part
    stiffness : ShellStiffness, or a sequence for a beam or bar
    """
    if not isinstance(material, Plastic) or law not in (linear_elastic, linear_shell):
        return law
    if law is linear_elastic:
        places, areas = section.fibres()
        return Fibres(places, areas, material, stiffness)
    if not isinstance(section, Plate):
        raise ValueError(f"{type(section).__name__}: has no layers, which a plastic material needs; give a Plate, or a "
                         "law of your own")
    places, weights = section.layers()
    return Layers(places, weights, material, stiffness)


class PlasticLaw(LawWithHistory):
    """A section law that knows where its points have flowed, for pictures and events.

    Attributes
    ----------
    pieces, unchecked : names of the part that flows and of its elastic rest, in a warning
    """

    pieces, unchecked = "layers", "transverse shear"
    _told = False

    def flowed(self, history: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Share of the thickness or area that has flowed, and largest equivalent plastic strain, at many points.

        Parameters
        ----------
        history : shape (points, remembered)
        """
        raise NotImplementedError

    def stresses(self, strains: np.ndarray, history: np.ndarray, at: np.ndarray) -> np.ndarray:
        """Stresses in the layer, or fibre, nearest to a place of the section, (points, 3 or 1).

        Parameters
        ----------
        strains, history : shapes (points, n) and (points, remembered), of an accepted state
        at : height of a shell, shape (1,), or distance along depth, and in space width, of a beam
        """
        raise NotImplementedError

    def elastic_utilisation(self, strains: np.ndarray) -> np.ndarray:
        """Largest stress over the yield stress, if the strains (points, n) were elastic: above 1 where they yield."""
        raise NotImplementedError

    def unchecked_squares(self, strains: np.ndarray) -> np.ndarray:
        """Square of the elastic value over the plastic one that it could reach alone, at strains (points, n)."""
        raise NotImplementedError

    def accepted(self, strains, history):
        """Warn once where forces that no yield condition has are beyond their plastic values, or weaken what flows."""
        squares = self.unchecked_squares(strains)
        flows = squares[self.flowed(history)[0] > 0].max(initial=0.0)
        ratio = sqrt(max(flows, squares.max(initial=0.0)))
        if self._told or not (flows > SHEARED or ratio > 1):
            return
        self._told = True
        if flows > SHEARED:
            said = (f"{self.pieces} flow where {self.unchecked}, elastic in this law, reach {sqrt(flows):.2g} of what "
                    "the section can carry of them alone; its moment goes up to all that it can bear without them, and "
                    f"should have fallen to {sqrt(max(1 - flows, 0.0)):.0%} of that")
        else:
            said = (f"{self.unchecked}, elastic in this law, reach {ratio:.2g} times what the section can carry of "
                    "them alone")
        warn(f"Plastic: {said}. Give the part a law of your own, or believe no load beyond this one")


class Layers(PlasticLaw):
    """Shell section law of a plastic material, integrated through the thickness; transverse shear is elastic.

    Strains come from `forms.section.linear_shell`. A point of which both faces are inside the yield surface, and
    that has never yielded, is not divided into layers.

    Parameters
    ----------
    places, weights : of the layers, from the mid-surface (length)
    material : Plastic
    stiffness : ShellStiffness of the elastic section
    """

    def __init__(self, places: np.ndarray, weights: np.ndarray, material: Plastic, stiffness):
        if material.hardening < 0:
            raise ValueError(f"Plastic: hardening is {material.hardening}; layers of a shell need 0 or more")
        self.places, self.weights, self.material = np.asarray(places, float), np.asarray(weights, float), material
        self.remembered = REMEMBERED * len(places)
        self._elastic = stiffness.uncoupled
        self._constants = (material.modulus, material.poisson, material.yield_stress, material.hardening,
                           material.kinematic)

    def update(self, strains, history):
        return _layers(np.ascontiguousarray(strains), np.ascontiguousarray(history), self.places, self.weights,
                       self._elastic, *self._constants)

    def energies(self, strains, history):
        return layer_energies(strains, history, self.places, self.weights, self._elastic, *self._constants)

    def flowed(self, history):
        strains = history.reshape(len(history), len(self.places), REMEMBERED)[..., -1]
        return (strains > 0) @ (self.weights / self.weights.sum()), strains.max(axis=1)

    def stresses(self, strains, history, at):
        layer = int(np.abs(self.places - at[0]).argmin())
        return _in_layer(np.ascontiguousarray(strains), np.ascontiguousarray(history), layer, self.places[layer],
                         *self._constants)

    def elastic_utilisation(self, strains):
        modulus, poisson, strength, *_ = self._constants
        e = strains[:, None, :3] + self.places[:, None] * strains[:, None, 3:6]
        one, two = (modulus / (1 - poisson**2) * (e[..., i] + poisson * e[..., 1 - i]) for i in (0, 1))
        shear = modulus / 2 / (1 + poisson) * e[..., 2]
        return np.sqrt(one**2 - one * two + two**2 + 3 * shear**2).max(axis=1) / strength

    def unchecked_squares(self, strains):
        return transverse_squares(strains, self._elastic, self.material.yield_stress * self.weights.sum())


class Fibres(PlasticLaw):
    """Beam section law of a plastic material by fibres along the axis; shear and torsion are elastic.

    Where all fibres flow perfectly the section keeps a millionth of its elastic moduli, and its resultants are exact.

    Strains come from `forms.beam.simo_reissner`, of a fibre e - y k_b in the plane, e - y k_b + z k_n in space, y
    being its distance along the normal (the direction of the depth) and z along the binormal.

    Parameters
    ----------
    places : shape (fibres, 2), of the fibres from the centroid along normal and binormal (length)
    areas : of the fibres; those whose strains are the same, side by side in the plane, are taken together
    material : Plastic
    stiffness : of the elastic section, in the order of the strains; one of a bar, three in the plane, six in space;
        or rows of a matrix, of which the fibres replace what they carry
    """

    pieces, unchecked = "fibres", "shear and torsion"

    def __init__(self, places: np.ndarray, areas: np.ndarray, material: Plastic, stiffness: Sequence):
        places = np.asarray(places, float).reshape(-1, 2)
        arms = np.zeros((len(places), len(stiffness)))
        arms[:, 0] = 1.0
        if len(stiffness) == 3:
            arms[:, 2] = -places[:, 0]
        elif len(stiffness) == 6:
            arms[:, 4], arms[:, 5] = places[:, 1], -places[:, 0]
        rounded = np.round(arms, 12 - int(np.floor(np.log10(np.abs(places).max() or 1.0))))
        _, first, same = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
        kept = np.argsort(first)
        self._arms, self.areas = arms[first[kept]], np.bincount(same.ravel(), np.asarray(areas, float))[kept]
        rest, given = ~self._arms.any(axis=0), np.asarray(stiffness, float)
        self._elastic = np.where(np.outer(rest, rest), np.diag(given) if given.ndim == 1 else given, 0.0)
        self._polar = np.asarray(areas, float) @ np.linalg.norm(places, axis=1)
        self.remembered = 3 * len(self.areas)
        self._constants = material.modulus, material.yield_stress, material.hardening, material.kinematic
        self._shear_modulus = material.shear_modulus

    def update(self, strains, history):
        return _fibres(np.ascontiguousarray(strains), np.ascontiguousarray(history), self._arms, self.areas,
                       self._elastic, *self._constants)

    def energies(self, strains, history):
        return fibre_energies(strains, history, self._arms, self.areas, self._elastic, *self._constants)

    def flowed(self, history):
        strains = history.reshape(len(history), -1, 3)[..., -1]
        return (strains > 0) @ (self.areas / self.areas.sum()), strains.max(axis=1)

    def stresses(self, strains, history, at):
        there = np.zeros((len(self._arms), 2))
        if strains.shape[1] > 1:
            there[:, 0] = -self._arms[:, -1]
        if strains.shape[1] == 6:
            there[:, 1] = self._arms[:, 4]
        wanted = np.zeros(2)
        wanted[:min(len(at), 2)] = at[:2]
        fibre = int(((there - wanted) ** 2).sum(axis=1).argmin())
        return _in_fibre(np.ascontiguousarray(strains), np.ascontiguousarray(history), fibre, self._arms[fibre],
                         *self._constants)

    def elastic_utilisation(self, strains):
        modulus, strength, *_ = self._constants
        return modulus / strength * np.abs(strains @ self._arms.T).max(axis=1)

    def unchecked_squares(self, strains):
        """Shear forces over A k, and the torque about the shear centre over its plastic value, k being s_y / sqrt(3).

        No torque is above k times the area's integral of the distance from an axis, nor above k sqrt(J A): the elastic
        stress has the least energy of all that balance a torque (Prager and Hodge 1951, section 12), T^2 / 2 G J, and
        the plastic one has k^2 A / 2 G. It is the plastic torque of a thin tube, and 15 % above a thin strip's.
        """
        area, strength = self.areas.sum(), self._constants[1] / sqrt(3)
        if strains.shape[1] < 3:
            return np.zeros(len(strains))
        forces = strains @ self._elastic / strength
        if strains.shape[1] == 3:
            return (forces[:, 1] / area) ** 2
        lever = np.linalg.solve(self._elastic[1:3, 1:3], self._elastic[1:3, 3])
        torsion = (self._elastic[3, 3] - self._elastic[3, 1:3] @ lever) / self._shear_modulus
        torque = (forces[:, 3] - forces[:, 1:3] @ lever) / min(self._polar, sqrt(torsion * area))
        return (forces[:, 1:3] ** 2).sum(axis=1) / area**2 + torque**2


def transverse_squares(strains: np.ndarray, elastic: np.ndarray, strength: float) -> np.ndarray:
    """Square of the transverse shear force of a shell over its plastic value, a yield force per length / sqrt(3)."""
    return 3 * ((strains[:, 6:8] @ elastic[6:8, 6:8] / strength) ** 2).sum(axis=1)


@numba.njit(cache=True)
def _in_fibre(strains, history, fibre, arms, modulus, strength, isotropic, kinematic):
    """Stress in a fibre at many points, shape (points, 1)."""
    found = np.empty((len(strains), 1))
    for q in range(len(strains)):
        strain = 0.0
        for i in range(strains.shape[1]):
            strain += arms[i] * strains[q, i]
        found[q, 0] = one_axis(strain, history[q, 3 * fibre], history[q, 3 * fibre + 1], history[q, 3 * fibre + 2],
                               modulus, strength, isotropic, kinematic)[0]
    return found


@numba.njit(cache=True)
def _in_layer(strains, history, layer, z, modulus, poisson, strength, isotropic, kinematic):
    """Stresses in a layer at many points, shape (points, 3)."""
    found, strain, tangent = np.empty((len(strains), 3)), np.empty(3), np.empty((3, 3))
    own, after = slice(REMEMBERED * layer, REMEMBERED * layer + REMEMBERED), np.empty(REMEMBERED)
    numbers = modulus, poisson, strength, isotropic, kinematic
    for q in range(len(strains)):
        for i in range(3):
            strain[i] = strains[q, i] + z * strains[q, 3 + i]
        plane_stress(strain, history[q, own], *numbers, found[q], tangent, after)
    return found


@numba.njit(cache=True)
def _fibres(strains, history, arms, areas, elastic, modulus, strength, isotropic, kinematic):
    """Sums over fibres at many points; each remembers plastic strain, back stress and equivalent plastic strain."""
    points, count = strains.shape
    resultants, moduli, after = np.zeros((points, count)), np.zeros((points, count, count)), np.empty_like(history)
    for q in range(points):
        moduli[q] = elastic
        resultants[q] = elastic @ strains[q]
        for f in range(len(areas)):
            strain = 0.0
            for i in range(count):
                strain += arms[f, i] * strains[q, i]
            stress, tangent, after[q, 3 * f], after[q, 3 * f + 1], after[q, 3 * f + 2] = one_axis(
                strain, history[q, 3 * f], history[q, 3 * f + 1], history[q, 3 * f + 2], modulus, strength, isotropic,
                kinematic)
            for i in range(count):
                resultants[q, i] += areas[f] * stress * arms[f, i]
                for j in range(count):
                    moduli[q, i, j] += areas[f] * tangent * arms[f, i] * arms[f, j]
    return resultants, moduli, after


@numba.njit(cache=True)
def _layers(strains, history, places, weights, elastic, modulus, poisson, strength, isotropic, kinematic):
    """Sums through the thickness at many points; each layer remembers REMEMBERED values."""
    points = len(strains)
    resultants, moduli, after = np.empty((points, 9)), np.empty((points, 9, 9)), np.empty_like(history)
    strain, stress, tangent = np.empty(3), np.empty(3), np.empty((3, 3))
    most, plane = (strength * (1 - ON_SURFACE)) ** 2, modulus / (1 - poisson**2)
    for q in range(points):
        moduli[q], resultants[q], after[q] = elastic, elastic @ strains[q], history[q]
        inside = True
        for layer in range(len(places)):
            inside = inside and history[q, REMEMBERED * layer + REMEMBERED - 1] == 0.0
        for z in (places[0], places[-1]):  # von Mises's stress is convex: faces bound the stresses between them
            for i in range(3):
                strain[i] = strains[q, i] + z * strains[q, 3 + i]
            one, two = plane * (strain[0] + poisson * strain[1]), plane * (poisson * strain[0] + strain[1])
            shear = plane * (1 - poisson) / 2 * strain[2]
            inside = inside and one * one - one * two + two * two + 3 * shear * shear < most
        if inside:
            continue
        resultants[q, :6], moduli[q, :6, :6] = 0.0, 0.0
        for layer in range(len(places)):
            z, weight = places[layer], weights[layer]
            own = slice(REMEMBERED * layer, REMEMBERED * layer + REMEMBERED)
            for i in range(3):
                strain[i] = strains[q, i] + z * strains[q, 3 + i]
            plane_stress(strain, history[q, own], modulus, poisson, strength, isotropic, kinematic, stress, tangent,
                         after[q, own])
            for i in range(3):
                resultants[q, i] += weight * stress[i]
                resultants[q, 3 + i] += weight * z * stress[i]
                for j in range(3):
                    value = weight * tangent[i, j]
                    moduli[q, i, j] += value
                    moduli[q, i, 3 + j] += z * value
                    moduli[q, 3 + i, j] += z * value
                    moduli[q, 3 + i, 3 + j] += z * z * value
    return resultants, moduli, after
