"""Circular arch under a rigid punch (thesis, section 4.5.2)."""

from __future__ import annotations

from math import pi, radians
from typing import Annotated

import numpy as np
from mpi4py import MPI
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, Choice, Range
from ..continuation.control import ArcLength
from ..mesh.reader import NamedMesh, read
from ..model.beam import Beam
from ..model.contact import Contact
from ..model.loads import ObstacleForce, PointForce
from ..model.obstacles import RigidCylinder
from ..model.scene import Monitor, Scene
from ..model.section import Rectangle
from ..model.supports import clamp, symmetry
from ..path import Path, Until
from ..record import Record
from ..show import contact as contact_pictures
from ..show.plastic import plastic_zones
from ..show.standard import STANDARD
from . import looked_at
from ._plastic import Hardening, Yield, material, plastic_quantities, yield_events

RADIUS, WIDTH, MODULUS = 3380.6, 25.4, 72395.0
FIBRES = 10  # an even number: one on the axis would let a section flow that has no stiffness left


@looked_at
def case(
    ratio: Annotated[float, POSITIVE, Option(help="radius of the punch over that of the arch")] = 1.0,
    no_punch: Annotated[bool, Option("--no-punch", help="point load instead of the punch")] = False,
    friction: Annotated[float, NOT_NEGATIVE, Option(help="Coulomb's coefficient between arch and punch")] = 0.0,
    half_angle: Annotated[float, Range(above=0, most=180),
                          Option(help="half of the arch's opening angle, degrees")] = 7.338,
    thickness: Annotated[float, POSITIVE, Option(help="depth of the section, mm")] = 4.7625,
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on half the arch")] = 320,
    degree: Annotated[int, Choice((1, 2, 3)), Option(help="of the elements: 1 (two nodes) or 2")] = 2,
    contact: Annotated[str, Choice(("nodes", "quadrature")),
                       Option(help="contact points: nodes or quadrature")] = "quadrature",
    layer: Annotated[float | None, NOT_NEGATIVE,
                     Option(help="contact layer, mm (0: exact); default as thin as is smooth")] = None,
    enforcement: Annotated[str | None, Choice(("penalty", "uzawa", "semismooth")),
                           Option(help="penalty, uzawa or semismooth; default the fastest")] = None,
    full: Annotated[bool, Option("--full", help="the whole arch instead of its symmetric half")] = False,
    imperfection: Annotated[float, Option(help="amplitude of an antisymmetric imperfection, mm (with --full)")] = 0.0,
    to: Annotated[float, POSITIVE, Option(help="deflection of the crown at which the path ends, mm")] = 40.0,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 0.005,
    yield_stress: Yield = None,
    hardening: Hardening = 0.0,
) -> Case:
    """Circular arch under a rigid punch: the thesis's benchmark B.

    With a yield stress also first yield and the share of the volume that has flowed at the limits.

    The thesis gives neither half angle nor supports; those of the classical clamped shallow arch
    are taken (same section, modulus and radius; half angle 7.338 degrees).
    """
    mesh = arch_model(half_angle, elements, degree, full, imperfection)
    beam = Beam(mesh, Rectangle(WIDTH, thickness, points=FIBRES), material(MODULUS, 0.3, yield_stress, hardening),
                degree=degree)
    symmetry_factor = 1 if full else 2
    contacts, pictures = [], list(STANDARD)
    if no_punch:
        loads = [PointForce(mesh, "crown", (0.0, -1.0 / symmetry_factor))]
    else:
        radius = ratio * RADIUS
        top = crown_height(mesh)
        punch = RigidCylinder(radius, (0.0, top + radius), travel=(0.0, -1.0))
        contacts = [Contact(beam, punch, contact, friction, distance=0.0, layer=layer, enforcement=enforcement)]
        loads = [ObstacleForce(punch, 1.0 / symmetry_factor)]
        pictures += [contact_pictures.contact_history, contact_pictures.tractions(500.0)]
    if yield_stress is not None:
        pictures.append(plastic_zones)
    scene = Scene(
        parts=[beam], contacts=contacts, loads=loads, symmetry_factor=symmetry_factor,
        supports=[clamp(mesh, "end"), clamp(mesh, "start") if full else symmetry(mesh, "crown")],
        monitor=Monitor(mesh, "crown", "y", -1.0))
    return Case(
        scene=scene, events=yield_events(scene),
        control=ArcLength(step=step, largest=2.0), until=Until(deflection=to),
        quantities=lambda record: quantities(record, thickness) | plastic_quantities(record), pictures=pictures,
        axes=("deflection of the crown (mm)", "load on the whole arch (N)"))


def arch_model(half_angle: float, elements: int, degree: int, full: bool, imperfection: float = 0.0) -> NamedMesh:
    """Mesh of the arch, or of its half from the crown, with the points start, crown and end."""
    if imperfection and not full:
        raise ValueError(f"arch: imperfection is {imperfection}, but an antisymmetric one needs the whole arch; add "
                         "--full")
    angle = radians(half_angle)
    start, count = (-angle, 2 * elements) if full else (0.0, elements)
    mesh = read(lambda: meshes.arc(RADIUS, start, angle, count, {"crown": 0.0}), 2, min(degree, 2))
    if imperfection:
        x = mesh.domain.geometry.x
        polar = np.arctan2(x[:, 0], x[:, 1])
        x[:, :2] += imperfection * np.sin(pi * polar / angle)[:, None] * x[:, :2] / RADIUS
    return mesh


def crown_height(mesh: NamedMesh) -> float:
    """Height of the mesh's highest point (of the crown where the arch is perfect)."""
    return mesh.comm.allreduce(float(mesh.domain.geometry.x[:, 1].max()), op=MPI.MAX)


def rise(mesh: NamedMesh) -> float:
    """Height of the mesh's highest point above its lowest."""
    return crown_height(mesh) - mesh.comm.allreduce(float(mesh.domain.geometry.x[:, 1].min()), op=MPI.MIN)


def quantities(record: Record, thickness: float) -> dict[str, float]:
    """Limit loads, and with a punch their ratio to the limit load of the same mesh without one.

    Contact at nodes makes the path a sawtooth with many limit points: the highest counts.
    """
    limits = [p for p in record.critical_points if p.kind == "limit"]
    values: dict[str, float] = {}
    if limits:
        highest = max(limits, key=lambda p: p.load)
        values |= {"limit_load": highest.load, "limit_deflection": highest.deflection}
        later = limits[limits.index(highest) + 1:]
        if later:
            lowest = min(later, key=lambda p: p.load)
            values |= {"lowest_load": lowest.load, "lowest_deflection": lowest.deflection}
    if record.case.scene.contacts:
        values["penetration_over_depth"] = max(s.penetration for s in record.states) / thickness
        if limits and (without := limit_without_contact(record)):
            values["limit_ratio"] = values["limit_load"] / without
    return values


def limit_without_contact(record: Record) -> float | None:
    """First limit load of the same arch under a point load; None where there is none, as for very shallow arches.

    The search ends when the crown has come down by twice the rise: the arch then hangs upside down.
    """
    scene = record.case.scene
    mesh = scene.parts[0].mesh
    bare = Scene(scene.parts, scene.supports, [PointForce(mesh, "crown", (0.0, -1.0 / scene.symmetry_factor))],
                 scene.monitor, symmetry_factor=scene.symmetry_factor)
    path = Path(bare, until=Until(deflection=2 * rise(mesh)))
    return next((p.load for state in path for p in state.critical if p.kind == "limit"), None)
