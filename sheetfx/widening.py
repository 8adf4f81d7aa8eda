"""Kernels of expressions that do several cells at once.

FFCx writes a kernel as a straight line of arithmetic for one cell, of which a compiler finds nothing that could be done
together. Here each number of that line becomes a vector with one entry for each of several cells, by the vector types
that GCC and Clang have, so that a processor does them all in the time of one. Conditions choose bit by bit from what is
computed for all cells, as in FFCx's kernels for each. Kernels with other functions stay as FFCx writes them, and so do
those that a compiler refuses.
"""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from ctypes import CDLL, c_int, c_void_p
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import numpy as np
import ufl
from cffi import FFI, VerificationError
from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.algorithms.analysis import extract_coefficients, extract_constants

from .compat import geometry_nodes

KERNEL = re.compile(r"^void tabulate_tensor_expression_\w+\(double\* restrict A,.*?\)\n(?={)", re.M | re.S)
POSITIONS = re.compile(r"^static int original_coefficient_positions_\w+\[\d+\] = {([^}]*)};", re.M)
NUMBER = re.compile(r"^( *)double (\w+) = (.*);$", re.M)
CONDITION = re.compile(r"^( *)bool (\w+) = (\S+ (?:[<>]=?|[!=]=) \S+|\w+ (?:&&|\|\|) \w+|!\w+);$", re.M)
CHOICE = re.compile(r"^(\w+) \? (\S+) : (\S+)$")
LOGIC = {"&&": "&", "||": "|", "!": "~"}  # of one cell, and of several; so are the functions
FUNCTIONS = {"sqrt": "root", "pow": "power", "fabs": "absolute", "fmax": "larger", "fmin": "smaller"}
# What is not arithmetic of numbers in a cell and choices: other conditions and functions, arrays, facets.
OTHER = re.compile(rf"\?|\bbool\b|\b(?!(?:for|choice|mask|{'|'.join(FUNCTIONS)})\b)[A-Za-z_]\w* ?\(|"
                   r"\bpow\((?!\w+, -?[\d.]+\))|(?<!static const )\bdouble\b|\bentity_local_index\[|"
                   r"\bquadrature_permutation\[")
# One of the compiler's arguments, by which kernels on disk that an earlier state of this file has made are told apart.
ARGUMENT = f"-DSHEETFX_WIDENING=0x{sha256(Path(__file__).read_bytes()).hexdigest()[:12]}"

BEFORE = """
#include <string.h>
#ifdef __AVX512F__
#define LANES 8
#else
#define LANES 4
#endif
enum { VALUES = %(values)d, COORDINATES = %(coordinates)d, ENTRIES = %(entries)d };
typedef double cells __attribute__((vector_size(8 * LANES)));
typedef int64_t masks __attribute__((vector_size(8 * LANES)));

#define AT_ONCE static inline __attribute__((always_inline)) cells

AT_ONCE roots(cells x)
{
  for (int lane = 0; lane < LANES; ++lane)
    x[lane] = sqrt(x[lane]);
  return x;
}

AT_ONCE powers(cells x, double exponent)
{
  for (int lane = 0; lane < LANES; ++lane)
    x[lane] = pow(x[lane], exponent);
  return x;
}

AT_ONCE chosen(masks from, cells x, cells y)
{
  return (cells)((from & (masks)x) | (~from & (masks)y));
}

#define all(x) _Generic((x), cells: (x), default: (cells){0} + (x))
#define mask(x) _Generic((x), masks: (x), default: (masks){0} - (x))
#define choice(from, x, y) chosen(from, all(x), all(y))
#define absolute(x) choice(mask((x) < 0), -(x), x)
#define larger(x, y) choice(mask((x) > (y)), x, y)
#define smaller(x, y) choice(mask((x) < (y)), x, y)
#define root(x) _Generic((x), cells: roots, default: sqrt)(x)
#define power(x, exponent) _Generic((x), cells: powers, default: pow)(x, exponent)

static void of_cells(cells* restrict A, const cells* restrict w, const double* restrict c,
                     const cells* restrict coordinate_dofs)
"""

AFTER = """

void tabulate_cells(double* restrict A, const double* const* values, const int32_t* const* dofs, const int* nodes,
                    const int* widths, int coefficients, const double* c, const double* x,
                    const int32_t* corners, const int32_t* entities, int count)
{
  cells w[VALUES + 1], coordinates[COORDINATES], results[ENTRIES];
  double *all_w = (double*)w, *all_coordinates = (double*)coordinates, *all_results = (double*)results;
  for (int first = 0; first < count; first += LANES)
  {
    int filled = count - first < LANES ? count - first : LANES;
    for (int lane = 0; lane < LANES; ++lane)
    {
      int64_t cell = entities[first + (lane < filled ? lane : 0)], place = lane;
      for (int k = 0; k < coefficients; ++k)
        for (int i = 0; i < nodes[k]; ++i)
        {
          const double* value = values[k] + (int64_t)dofs[k][cell * nodes[k] + i] * widths[k];
          for (int j = 0; j < widths[k]; ++j, place += LANES)
            all_w[place] = value[j];
        }
      for (int i = 0; i < COORDINATES; ++i)
        all_coordinates[LANES * i + lane] = x[3 * (int64_t)corners[cell * (COORDINATES / 3) + i / 3] + i %% 3];
    }
    memset(results, 0, sizeof(results));
    of_cells(results, w, c, coordinates);
    for (int lane = 0; lane < filled; ++lane)
      for (int i = 0; i < ENTRIES; ++i)
        A[(int64_t)(first + lane) * ENTRIES + i] = all_results[LANES * i + lane];
  }
}

%(head)s{
  cells all_w[VALUES + 1], coordinates[COORDINATES], results[ENTRIES];
  for (int i = 0; i < VALUES; ++i)
    all_w[i] = (cells){0} + w[i];
  for (int i = 0; i < COORDINATES; ++i)
    coordinates[i] = (cells){0} + coordinate_dofs[i];
  memset(results, 0, sizeof(results));
  of_cells(results, all_w, c, coordinates);
  for (int i = 0; i < ENTRIES; ++i)
    A[i] += results[i][0];
}
"""


def builder_for(expression, points: np.ndarray) -> Callable[[], Builder]:
    """What stands in for `cffi.FFI` where FFCx makes a library of the kernel of an expression at so many points."""
    return lambda: Builder(lambda source: _widened(source, expression, len(points)))


class Builder:
    """A library of FFCx's source, rewritten; of the source as it is where the compiler refuses what is rewritten.

    It has those methods of `cffi.FFI` that FFCx calls, in their order.
    """

    def __init__(self, rewritten: Callable[[str], str]):
        self._rewritten = rewritten

    def set_source(self, name: str, source: str, **options):
        self._name, self._source, self._options = name, source, options

    def cdef(self, declarations: str):
        self._declarations = declarations

    def compile(self, **options) -> str:
        """Compile the library; a warning has the first error where the compiler refuses what is rewritten."""
        rewritten = self._rewritten(self._source)
        if rewritten == self._source:
            return self._compiled(self._source, options)
        with TemporaryFile("w+") as heard:
            try:
                with _errors_to(heard):
                    file = self._compiled(rewritten, options)
                refusal = ""
            except VerificationError as error:
                file, refusal = self._compiled(self._source, options), str(error)
            heard.seek(0)
            said = heard.read()
        if refusal:
            reason = re.search(r"error: (.*)", said)
            warnings.warn(f"a kernel does one cell at a time, since the compiler refuses several: "
                          f"{reason[1] if reason else refusal}", RuntimeWarning, stacklevel=2)
        elif said:
            print(said, end="", file=sys.stderr)
        return file

    def _compiled(self, source: str, options: dict) -> str:
        builder = FFI()
        builder.set_source(self._name, source, **self._options)
        builder.cdef(self._declarations)
        return builder.compile(**options)


@contextmanager
def _errors_to(file: IO) -> Iterator[None]:
    """Lead what this process and those that it starts print as errors to a file."""
    sys.stderr.flush()
    usual = os.dup(2)
    os.dup2(file.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(usual, 2)
        os.close(usual)


def _widened(source: str, expression, points: int) -> str:
    """The source of a library whose kernel does several cells at once; as it is where that cannot be."""
    kernel, mesh = KERNEL.search(source), _mesh_of(expression)
    if kernel is None or mesh is None:
        return source
    end = _end_of_block(source, kernel.end())
    body = CONDITION.sub(_as_masks, NUMBER.sub(_as_cells, source[kernel.end(): end]))
    if OTHER.search(body):
        return source
    used = _used(source, extract_coefficients(expression))
    corners, entries = mesh.ufl_coordinate_element(), points * int(np.prod(expression.ufl_shape))
    sizes = {"values": sum(c.ufl_function_space().ufl_element().dim for c in used), "entries": entries,
             "coordinates": 3 * corners.dim // corners.block_size, "head": kernel[0]}
    body = re.sub(rf"\b({'|'.join(FUNCTIONS)})\(", lambda found: f"{FUNCTIONS[found[1]]}(", body)
    return source[:kernel.start()] + BEFORE % sizes + body + AFTER % sizes + source[end:]


def _end_of_block(source: str, start: int) -> int:
    """Place behind the brace that closes the block which begins at another place."""
    depth = 0
    for brace in re.finditer("[{}]", source[start:]):
        depth += 1 if brace[0] == "{" else -1
        if not depth:
            return start + brace.end()
    raise ValueError("a kernel without end")


def _as_cells(number: re.Match) -> str:
    """A declaration of a number as one of a vector; numbers that are the same in all cells stay so."""
    indent, name, value = number.groups()
    value = CHOICE.sub(r"choice(\1, \2, \3)", value)
    return f"{indent}cells {name} = {{0}};" if value == "0.0" else f"{indent}__auto_type {name} = {value};"


def _as_masks(condition: re.Match) -> str:
    """A declaration of a condition as one of a vector with all bits of a cell set where it holds there."""
    indent, name, value = condition.groups()
    value = re.sub(r"&&|\|\||!(?!=)", lambda found: LOGIC[found[0]], value)
    return f"{indent}masks {name} = mask({value});"


def _used(source: str, coefficients: list) -> list:
    """Coefficients that a kernel takes, in its order."""
    positions = POSITIONS.search(source)
    return [coefficients[int(n)] for n in positions[1].split(",")] if positions else []


def _mesh_of(expression):
    """The mesh on which an expression and all its coefficients are, if it has values in cells; None: there is none."""
    domains = set(ufl.domain.extract_domains(expression)) | {c.ufl_domain() for c in extract_constants(expression)}
    spaces = [c.ufl_function_space() for c in extract_coefficients(expression)]
    domains |= {space.ufl_domain() for space in spaces}
    plain = all(space.ufl_element().pullback == ufl.identity_pullback for space in spaces)
    return domains.pop() if len(domains) == 1 and plain and not ufl.algorithms.extract_arguments(expression) else None


class CellExpression(fem.Expression):
    """An expression whose kernel may do several cells at once.

    Parameters
    ----------
    library : what says in which file the kernel is, once it is there

    Attributes
    ----------
    several : whether it does
    """

    def __init__(self, expression, points: np.ndarray, library: Callable[[], Path], **options):
        super().__init__(expression, points, **options)
        kernel, coefficients = self.ufcx_expression, extract_coefficients(expression)
        used = [coefficients[kernel.original_coefficient_positions[n]] for n in range(kernel.num_coefficients)]
        self._tabulate = getattr(CDLL(str(library())), "tabulate_cells", None)
        self.several = self._tabulate is not None and not any(
            c.function_space.element.needs_dof_transformations for c in used)
        if self.several:
            self._mesh, self._constants = _mesh_of(expression).ufl_cargo(), extract_constants(expression)
            self._entries = len(points) * self.value_size
            maps, values = [c.function_space.dofmap for c in used], [c.x.array for c in used]
            self._kept = values, [np.ascontiguousarray(m.list) for m in maps]
            self._coefficients = (*map(_pointers, self._kept), _numbers([m.list.shape[1] for m in maps]),
                                  _numbers([m.bs for m in maps]), len(used))

    def eval(self, mesh: Mesh, entities: np.ndarray, values: np.ndarray | None = None) -> np.ndarray:
        """Values in cells, (cells, points * components), as `fem.Expression.eval` has them."""
        if not self.several or values is not None or mesh._cpp_object is not self._mesh:
            return super().eval(mesh, entities, values)
        cells, found = np.ascontiguousarray(entities, dtype=np.int32), np.empty((len(entities), self._entries))
        constants = np.concatenate([[0.0], *(np.ravel(c.value) for c in self._constants)])[1:]
        places, corners = mesh.geometry.x, geometry_nodes(mesh)
        self._tabulate(_address(found), *self._coefficients, _address(constants), _address(places), _address(corners),
                       _address(cells), len(cells))
        return found


def _address(array: np.ndarray) -> c_void_p:
    return c_void_p(array.ctypes.data)


def _pointers(arrays: Sequence[np.ndarray]):
    return (c_void_p * max(len(arrays), 1))(*(array.ctypes.data for array in arrays))


def _numbers(values: Sequence[int]):
    return (c_int * max(len(values), 1))(*values)
