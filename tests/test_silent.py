"""Inputs that once gave a wrong number without a word, by name; `pytest tests -m silent` runs what holds them now."""

from __future__ import annotations

import re
from pathlib import Path

ROWS = {
    "b01": "product of inertia of fibres: an L on two hinges buckles at 165 610 N",
    "b02": "panels of one shell whose cells run the other way: pressure on one side",
    "b03": "the skin of a mixed mesh made imperfect alone: refused, or moved with its rib",
    "b04": "curves of one group that run the other way: an arch carries its pressure by (82.0, 56.5)",
    "b05": "any number of groups that carry loads",
    "b10": "parts on groups that overlap: refused, or layers that are told",
    "b12": "contact of beams at their faces, whatever the class",
    "b13": "groups without names of several dimensions",
    "b14": "parts on a mesh and on a group of it",
    "f01": "an offset with strains of one's own",
    "f02": "a monitored rotation in space: an angle, whatever the steps",
    "f03": "pressure and own loads of a part of a structure: neither multiplied nor added",
    "f04": "the length of an obstacle's travel",
    "f05": "balance of energy where a load follows after a stage",
    "f06": "springs on an edge, on two processes",
    "g03": "shared nodes of shells of unequal degrees or cells: told",
    "linear": "linear buckling with pairs or obstacles that may touch: told",
    "m2_bars": "elastic-plastic bars by steps of any length",
    "p01": "beam-columns of AISC 360",
    "p02": "an elastica with a lever at its tip",
    "p03": "a helix of ten turns",
    "p04": "a heated disc that leaves its sphere",
    "pairs": "bifurcations beside pairs that touch without pressure: told",
    "q01": "transverse shear of plies: a sandwich bends by 0.1222 in",
    "q02": "an offset on a curved surface: per length and area of the mid-surface",
    "q03": "contact at the faces of the cells that touch",
    "q04": "linear buckling where the tangent is not linear in the load: told by how much",
    "q13": "springs at the nodes of an edge: told",
    "q16": "densities of plies",
    "q17": "cells that a place bends: curved",
    "q18": "loads so small that residuals are rounding",
    "stiff": "ties that hold next to the same: never stiffer than one mesh",
    "t02": "balance of energy under a pressure that is held",
    "t03": "a limit point of friction within a step, and load control beyond it",
    "t04": "an arch that falls on a floor: extremes of its path, by default steps",
    "t09": "friction by steps of any length",
    "toggles": "plastic bars that are strained back within a step",
    "u01": "unloading after a part has flowed, by default settings",
    "u02": "shear and torsion beyond their plastic values: told",
    "u03": "a plateau: one limit at most",
    "u04": "a rotation prescribed twice: refused by name",
    "u05": "a load beyond the plastic limit: named",
    "u06": "a Flanged of a Flanged",
    "u07": "a bifurcation of the comparison solid at which a path ends: named",
}


def test_each_row_has_a_test():
    """And each mark is a row."""
    marked = set()
    for file in Path(__file__).parent.rglob("test_*.py"):
        for names in re.findall(r"^(?:pytestmark = |@)pytest\.mark\.silent\((.*)\)$", file.read_text(), re.MULTILINE):
            marked |= set(re.findall(r'"(\w+)"', names))
    assert marked == set(ROWS)

