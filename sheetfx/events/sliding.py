"""Events of parts that come to touch, and that slide off each other."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..continuation.state import State
from ..discrete.surface_partners import MARGIN
from ..model.pair_contact import PairContact
from ..model.scene import Scene
from ..model.surface_contact import SurfaceContact
from ..rounding import NONE
from .event import Event


def first_touch() -> Event:
    """Event at which contact begins, or ends."""
    return Event("first touch", _touches)


def _touches(state: State) -> bool:
    return state.contact_points > 0


def slide_off(scene: Scene, contact: SurfaceContact) -> Event:
    """Event at which the first point of a contact reaches the edge of the surface that it slides along.

    Raises
    ------
    ValueError
        If the scene does not have the contact, or it is one of pairs, which do not know how far an end is.
    """
    contacts = [joint for joint in scene.joints if isinstance(joint, (PairContact, SurfaceContact))]
    if contact not in contacts:
        raise ValueError("slide_off: the scene does not have the contact; give one of its joints")
    if not isinstance(contact, SurfaceContact):
        raise ValueError(f"slide_off: contact is the {contact.name}, whose pairs have no margin; give a "
                         "SurfaceContact, or watch the displacement of the point that slides by an Event of your own")
    name = f"contact{contacts.index(contact)} partners"
    return Event("slide-off", partial(_margin, name, contact.to[0].size), NONE * contact.to[0].size)


def _margin(name: str, farthest: float, state: State) -> float:
    """Distance of points from the edge, the shortest one."""
    return float(np.minimum(state.fields[name][:, MARGIN], farthest).min(initial=farthest))
