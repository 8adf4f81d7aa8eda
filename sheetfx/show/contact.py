"""Pictures of contact tractions and of how contact develops along a path."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as Folder

import numpy as np

from ..continuation.state import State
from ..discrete.contact import OPEN, SLIP, STICK, ContactState
from ..model.loads import FORCE
from ..model.reported import counted
from ..notices import warn
from .evaluate import ContactPoints, communicator, last_state_kept, unit_of, with_unit
from .shown import Shown

NORMAL, TANGENTIAL, TOUCHING = "#0b4f8a", "#c4432b", "#b8b8b8"


def tractions(load: float) -> Callable[[Shown, Folder], None]:
    """A picture of the contact forces at the state nearest to a total load, before the first critical point.

    Contact at nodes is drawn as the force of each node; contact at quadrature points, whose forces
    depend on how many there are, as force per length.
    """

    def picture(record: Shown, folder: Folder) -> None:
        if not _has_contact(record, "tractions.png"):
            return
        state = record.nearest(load)
        points = ContactPoints(record)
        with last_state_kept(record):
            record.show(state)
            contacts = points.evaluate()
        if contacts is not None:
            draw_tractions(record, state, contacts).savefig(Folder(folder) / "tractions.png", dpi=150)

    return picture


def draw_tractions(record: Shown, state: State, contacts: list[ContactState]):
    """The matplotlib figure of `tractions`."""
    figure, (axes,) = _figure(1)
    length, load, force = _units(record)
    scene = record.case.scene
    nodal = all(c.points == "nodes" for c in scene.contacts)
    for contact in contacts:
        weight = contact.weight if nodal else np.ones_like(contact.weight)
        draw = _stems if nodal else _densities
        draw(axes, contact, contact.pressure * weight, NORMAL,
             _total("normal", contact.pressure, contact, force, scene))
        if any(c.friction for c in scene.contacts):
            draw(axes, contact, contact.traction * weight, TANGENTIAL,
                 _total("tangential", contact.traction, contact, force, scene))
    _limit_to_touching(axes, contacts)
    axes.axhline(0, color="black", linewidth=0.7)
    quantity = "contact force of a node" if nodal else "contact force per length"
    axes.set_ylabel(quantity + _brackets(force if nodal else _per_length(force, length)))
    part = f", one of {scene.symmetry_factor} equal parts" if scene.symmetry_factor > 1 else ""
    axes.set_xlabel(f"current position x{_brackets(length)}{part}")
    axes.legend(frameon=True, framealpha=0.9, edgecolor="none", fontsize=9,
                title=f"at load {with_unit(state.load, load)}, deflection {with_unit(state.deflection, length)}",
                title_fontsize=9, alignment="left")
    return figure


def contact_history(record: Shown, folder: Folder) -> None:
    """Draw numbers of contact points, the largest pressure and its place along the path."""
    if not _has_contact(record, "contact_history.png"):
        return
    points, rows = ContactPoints(record), []
    with last_state_kept(record):
        for state in record.states:
            record.show(state)
            contacts = points.evaluate()
            if contacts is not None:
                rows.append(summarise(contacts))
    if rows:
        table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        draw_history(record, table).savefig(Folder(folder) / "contact_history.png", dpi=150)


def summarise(contacts: list[ContactState]) -> dict[str, float]:
    """Numbers of touching, sticking and slipping points; largest pressure and place of contact (NaN: none)."""
    pressure, status, x = (np.concatenate([getattr(c, n) if n != "x" else c.position[:, 0] for c in contacts])
                           for n in ("pressure", "status", "x"))
    touching = status != OPEN
    peak = int(np.argmax(pressure))
    return {
        "touching": int(touching.sum()), "sticking": int((status == STICK).sum()),
        "slipping": int((status == SLIP).sum()), "pressure": float(pressure[peak]),
        "peak": float(x[peak]) if touching.any() else np.nan,
        "first": float(x[touching].min()) if touching.any() else np.nan,
        "last": float(x[touching].max()) if touching.any() else np.nan,
    }


def draw_history(record: Shown, table: dict[str, np.ndarray]):
    """The matplotlib figure of `contact_history`.

    Parameters
    ----------
    table : names and values of `summarise`, each (states,)
    """
    deflection = np.array([s.deflection for s in record.states])
    length, _, force = _units(record)
    forwards = (np.diff(deflection) > 0).all()
    along = deflection if forwards else np.array([s.step for s in record.states])
    figure, (numbers, pressure, place) = _figure(3)
    style = {"marker": ".", "markersize": 4, "linewidth": 1.3}
    numbers.plot(along, table["touching"], color=TOUCHING, label="touching", linewidth=4)
    if any(c.friction for c in record.case.scene.contacts):
        numbers.plot(along, table["sticking"], color=NORMAL, label="sticking", **style)
        numbers.plot(along, table["slipping"], color=TANGENTIAL, label="slipping", **style)
    numbers.set_ylabel("contact points")
    numbers.yaxis.get_major_locator().set_params(integer=True)
    pressure.plot(along, table["pressure"], color=NORMAL, label="largest pressure", **style)
    pressure.set_ylabel("largest pressure" + _brackets(_per_length(force, length)))
    place.fill_between(along, table["first"], table["last"], color=NORMAL, alpha=0.2, linewidth=0, label="contact zone")
    place.plot(along, table["peak"], color=NORMAL, label="largest pressure", **style)
    place.set_ylabel("position x" + _brackets(length))
    place.set_xlabel(record.case.axes[0] if forwards else "step")
    for axes in (numbers, pressure, place):
        _mark_critical_points(axes, record, forwards)
    for axes in (numbers, place):
        axes.legend(frameon=True, framealpha=0.9, edgecolor="none", fontsize=9)
    figure.align_ylabels()
    if record.case.scene.symmetry_factor > 1:
        numbers.set_ylabel(f"contact points\n(one of {record.case.scene.symmetry_factor} equal parts)")
    return figure


def _mark_critical_points(axes, record: Shown, by_deflection: bool) -> None:
    for i, point in enumerate(record.critical_points):
        axes.axvline(point.deflection if by_deflection else point.step, color="#999999", linewidth=0.8, linestyle=":",
                     label="critical point" if i == 0 else None, zorder=1)


def _figure(rows: int):
    """A figure and its axes, one above the other."""
    from .figure import Picture

    figure = Picture(figsize=(8.0, 4.6 if rows == 1 else 2.4 * rows), layout="constrained")
    all_axes = figure.subplots(rows, sharex=True, squeeze=False)[:, 0]
    for axes in all_axes:
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, all_axes


def _stems(axes, contact: ContactState, values: np.ndarray, colour: str, label: str) -> None:
    touching = contact.status != OPEN
    x, values = contact.position[touching, 0], values[touching]
    axes.vlines(x, 0, values, color=colour, linewidth=1.5)
    axes.plot(x, values, "o", color=colour, markersize=4.5, label=label)


def _densities(axes, contact: ContactState, values: np.ndarray, colour: str, label: str) -> None:
    x = contact.position[:, 0]
    axes.fill_between(x, 0, values, color=colour, alpha=0.15, linewidth=0)
    axes.plot(x, values, ".-", color=colour, markersize=4, linewidth=1.3, label=label)


def _limit_to_touching(axes, contacts: list[ContactState]) -> None:
    """Show the contact zone and its surroundings."""
    x = np.concatenate([c.position[c.status != OPEN, 0] for c in contacts])
    if len(x):
        everywhere = np.concatenate([c.position[:, 0] for c in contacts])
        margin = max(0.5 * np.ptp(x), 0.01 * np.ptp(everywhere))
        axes.set_xlim(max(x.min() - margin, everywhere.min() - margin / 4), x.max() + margin)


def _total(name: str, density: np.ndarray, contact: ContactState, unit: str, scene) -> str:
    """Label with the resultant on the part that is modelled and on the whole structure."""
    total, pushed = contact.weight @ density, contact.weight @ contact.pressure
    total = float(total) if abs(total) > 1e-6 * pushed else 0.0
    label = f"{name}, sum {with_unit(total, unit)}"
    if scene.symmetry_factor > 1:
        label += f" in each of {scene.symmetry_factor} parts, {with_unit(scene.symmetry_factor * total, unit)} in all"
    return label


def _has_contact(record: Shown, name: str) -> bool:
    if not record.case.scene.contacts and communicator(record).rank == 0:
        warn(f"{name} is not drawn: the scene has no contact")
    return bool(record.case.scene.contacts)


def _brackets(unit: str) -> str:
    return f" ({unit})" if unit else ""


def _units(record: Shown) -> tuple[str, str, str]:
    """Of lengths, of the load, and of forces, which is the load's where the load is one."""
    length, load = map(unit_of, record.case.axes)
    return length, load, load if counted(record.case.scene.loads)[0] == FORCE else ""


def _per_length(force: str, length: str) -> str:
    return f"{force}/{length}" if force and length else ""
