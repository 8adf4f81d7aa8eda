"""Plasticity of shells by stress resultants: Ilyushin's yield condition with isotropic hardening."""

from __future__ import annotations

import numba
import numpy as np

from .plastic_energy import isotropic_energies, quadratic
from .plasticity import Plastic, PlasticLaw, transverse_squares
from .plate import Plate
from .return_mapping import ON_SURFACE

MOST, EXACT = 100, 1e-13  # iterations for the multipliers, and how well the yield condition then holds
ROOT = 0.5**0.5
REMEMBERED = 7  # plastic strains (e11, e22, 2 e12), plastic curvatures likewise, equivalent plastic strain


class Ilyushin(PlasticLaw):
    """Shell section law that flows as a whole, without layers; transverse shear is elastic.

    With the squares of von Mises's norm Q_N, Q_M of membrane forces and moments and their product Q_NM, the section
    yields where

        Q_N / N_0^2 + Q_M / M_0^2 + |Q_NM| / (sqrt(3) N_0 M_0) = (1 + H a / s_y)^2,   N_0 = s_y t,   M_0 = s_y t^2 / 4,

    an approximation of Ilyushin (1948) to the exact surface, a being the equivalent plastic strain whose work is that
    of the resultants. The two signs of Q_NM are two surfaces (Simo and Kennedy 1992); where both flow, in pure bending
    or stretching, they share an edge. The return is implicit, and its moduli belong to the resultants that it gives.

    It is exact for membranes and the fully plastic moment; a bent section stays elastic until all of it flows, 1.5
    times too long for a rectangle.

    Parameters
    ----------
    section : Plate
    material : Plastic without kinematic hardening; hardening must not be negative
    """

    remembered = REMEMBERED
    pieces = "sections"

    def __init__(self, section: Plate, material: Plastic):
        if not isinstance(material, Plastic):
            raise ValueError(f"Ilyushin: material is {material}; it needs an fx.Plastic")
        if not isinstance(section, Plate):
            raise ValueError(f"Ilyushin: section is {section}; it needs an fx.Plate, whose thickness is one piece")
        if material.kinematic or material.hardening < 0:
            raise ValueError(f"Ilyushin: kinematic is {material.kinematic}, hardening {material.hardening}; this law "
                             "hardens isotropically, without softening; leave out law=, which takes layers")
        self._elastic = section.stiffness(material).uncoupled
        self._constants = (section.thickness, material.modulus, material.poisson, material.yield_stress,
                           material.hardening)

    def update(self, strains, history):
        resultants, moduli = strains @ self._elastic, np.tile(self._elastic, (len(strains), 1, 1))
        after = np.array(history)
        _update(np.ascontiguousarray(strains), after, resultants, moduli, *self._constants)
        return resultants, moduli, after

    def energies(self, strains, history):
        thickness, _, _, strength, hardening = self._constants
        within = strains.copy()
        within[:, :6] -= history[:, :6]
        stored, dissipated = isotropic_energies(thickness * history[:, 6], strength, hardening / thickness)
        return quadratic(within, self._elastic) + stored, dissipated

    def flowed(self, history):
        return (history[:, -1] > 0).astype(float), history[:, -1]

    def unchecked_squares(self, strains):
        return transverse_squares(strains, self._elastic, self._constants[3] * self._constants[0])

    def elastic_utilisation(self, strains):
        thickness, _, _, strength, _ = self._constants
        n, m = (strains[:, part] @ self._elastic[part, part] / size for part, size in (
            (slice(0, 3), strength * thickness), (slice(3, 6), strength * thickness**2 / 4)))

        def product(a, b):
            return (a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] - (a[:, 0] * b[:, 1] + a[:, 1] * b[:, 0]) / 2
                    + 3 * a[:, 2] * b[:, 2])

        return np.sqrt(product(n, n) + product(m, m) + np.abs(product(n, m)) / np.sqrt(3))


@numba.njit(cache=True)
def _update(strains, history, resultants, moduli, thickness, modulus, poisson, strength, hardening):
    """Returns at many points, written over the elastic resultants and moduli and over the history.

    In the eigenvectors of elasticity and von Mises's norm force and moment, over N_0 and M_0, are three pairs (n, m);
    `compliance` is theirs, and `norm` the eigenvalues of the norm.
    """
    sizes = np.array((strength * thickness, strength * thickness**2 / 4))
    stiffness = np.array((modulus / (1 - poisson), modulus / (1 + poisson), modulus / (1 + poisson) / 2))
    norm = np.array((0.5, 1.5, 3.0))
    compliance = np.empty((3, 2))
    for i in range(3):
        compliance[i, 0] = sizes[0] ** 2 / (thickness * stiffness[i])
        compliance[i, 1] = sizes[1] ** 2 / (thickness**3 / 12 * stiffness[i])
    rate = 2 * hardening / (strength**2 * thickness)
    trial, pairs, spread = np.empty((3, 2)), np.empty((3, 2)), np.empty((3, 2, 2))
    slopes, answers = np.empty((2, 3, 2)), np.empty((2, 3, 2))
    flows, multipliers, value, matrix, inverse = (np.zeros(2, dtype=np.bool_), np.zeros(2), np.zeros(2),
                                                  np.zeros((2, 2)), np.zeros((2, 2)))
    own, turned, flow, force = np.empty((6, 6)), np.empty((6, 6)), np.empty(6), np.empty(6)
    for q in range(len(strains)):
        for kind in range(2):
            one = strains[q, 3 * kind] - history[q, 3 * kind]
            two = strains[q, 3 * kind + 1] - history[q, 3 * kind + 1]
            trial[0, kind], trial[1, kind] = sizes[kind] * ROOT * (one + two), sizes[kind] * ROOT * (two - one)
            trial[2, kind] = sizes[kind] * (strains[q, 3 * kind + 2] - history[q, 3 * kind + 2])
        start = 1 + hardening * history[q, 6] / strength
        multipliers[0] = multipliers[1] = 0.0
        _pairs(trial, compliance, norm, multipliers, pairs, spread, slopes)
        for s in range(2):
            value[s] = _excess(pairs, norm, s) - start**2
            flows[s] = value[s] > -2 * ON_SURFACE * start**2
        if not (flows[0] or flows[1] or history[q, 6] > 0):
            continue
        size = start
        for _ in range(MOST):
            share = 1 - rate * (multipliers[0] + multipliers[1])
            size = start / share
            _pairs(trial, compliance, norm, multipliers, pairs, spread, slopes)
            largest = 0.0
            for s in range(2):
                value[s] = _excess(pairs, norm, s) - size**2
                if not flows[s] and value[s] > EXACT * size**2:
                    flows[s] = True
                if flows[s] and (multipliers[s] > 0 or value[s] > 0):
                    largest = max(largest, abs(value[s]))
                for i in range(3):
                    for a in range(2):
                        answers[s, i, a] = spread[i, a, 0] * slopes[s, i, 0] + spread[i, a, 1] * slopes[s, i, 1]
            for s in range(2):
                for r in range(2):
                    matrix[s, r] = 2 * rate * size**2 / share
                    for i in range(3):
                        matrix[s, r] += slopes[s, i, 0] * answers[r, i, 0] + slopes[s, i, 1] * answers[r, i, 1]
            if largest <= EXACT * size**2:
                break
            _correct(multipliers, value, matrix, flows, inverse)
        _invert(matrix, flows, inverse)
        for a in range(6):
            for b in range(6):
                own[a, b] = spread[a % 3, a // 3, b // 3] if a % 3 == b % 3 else 0.0
                for s in range(2):
                    for r in range(2):
                        own[a, b] -= answers[s, a % 3, a // 3] * inverse[s, r] * answers[r, b % 3, b // 3]
        for a in range(6):
            flow[a] = multipliers[0] * slopes[0, a % 3, a // 3] + multipliers[1] * slopes[1, a % 3, a // 3]
            force[a] = pairs[a % 3, a // 3]
            _turn_back(own[a])
        _turn_back(flow)
        _turn_back(force)
        for a in range(6):
            history[q, a] += flow[a] / sizes[a // 3]
            resultants[q, a] = sizes[a // 3] * force[a]
            for b in range(6):
                turned[a, b] = own[b, a]
            _turn_back(turned[a])
        for a in range(6):
            for b in range(6):
                moduli[q, a, b] = sizes[a // 3] * sizes[b // 3] * turned[a, b]
        history[q, 6] += 2 * (multipliers[0] + multipliers[1]) * size / (strength * thickness)


@numba.njit(cache=True)
def _pairs(trial, compliance, norm, multipliers, pairs, spread, slopes):
    """Pairs (n, m) for given multipliers, their derivatives by the trial strains, and the slopes of both surfaces."""
    whole, difference = multipliers[0] + multipliers[1], (multipliers[0] - multipliers[1]) / np.sqrt(3.0)
    for i in range(3):
        a, b, c = (compliance[i, 0] + 2 * whole * norm[i], norm[i] * difference,
                   compliance[i, 1] + 2 * whole * norm[i])
        determinant = a * c - b * b
        spread[i, 0, 0], spread[i, 1, 1] = c / determinant, a / determinant
        spread[i, 0, 1] = spread[i, 1, 0] = -b / determinant
        for k in range(2):
            pairs[i, k] = spread[i, k, 0] * trial[i, 0] + spread[i, k, 1] * trial[i, 1]
        for s in range(2):
            sign = (1 - 2 * s) / np.sqrt(3.0)
            slopes[s, i, 0] = norm[i] * (2 * pairs[i, 0] + sign * pairs[i, 1])
            slopes[s, i, 1] = norm[i] * (2 * pairs[i, 1] + sign * pairs[i, 0])


@numba.njit(cache=True)
def _turn_back(values):
    """Take two triples from the eigenvectors to the axes of the section, in place."""
    for start in (0, 3):
        one, two = values[start], values[start + 1]
        values[start], values[start + 1] = ROOT * (one - two), ROOT * (one + two)


@numba.njit(cache=True)
def _excess(pairs, norm, surface):
    """Left side of the yield condition, with the sign of one surface."""
    sign, total = (1 - 2 * surface) / np.sqrt(3.0), 0.0
    for i in range(3):
        n, m = pairs[i, 0], pairs[i, 1]
        total += norm[i] * (n * n + m * m + sign * n * m)
    return total


@numba.njit(cache=True)
def _invert(matrix, flows, found):
    """Fill in the inverse of the rows and columns of surfaces that flow, zero elsewhere."""
    found[0, 0] = found[0, 1] = found[1, 0] = found[1, 1] = 0.0
    if flows[0] and flows[1]:
        determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
        found[0, 0], found[1, 1] = matrix[1, 1] / determinant, matrix[0, 0] / determinant
        found[0, 1] = found[1, 0] = -matrix[0, 1] / determinant
    elif flows[0]:
        found[0, 0] = 1 / matrix[0, 0]
    elif flows[1]:
        found[1, 1] = 1 / matrix[1, 1]


@numba.njit(cache=True)
def _correct(multipliers, value, matrix, flows, inverse):
    """Newton's step of the multipliers; a surface whose multiplier turns negative stops flowing."""
    _invert(matrix, flows, inverse)
    for s in range(2):
        if flows[s] and multipliers[s] + inverse[s, 0] * value[0] + inverse[s, 1] * value[1] < 0:
            flows[s], multipliers[s] = False, 0.0
            _invert(matrix, flows, inverse)
    for s in range(2):
        if flows[s]:
            multipliers[s] = max(0.0, multipliers[s] + inverse[s, 0] * value[0] + inverse[s, 1] * value[1])
