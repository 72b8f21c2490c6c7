"""`Polytope`: a bounded convex set, known by its halfspaces, that may be degenerate (line, plane).

A set of R^k is kept as ``{ x = x0 + B u : N u ≤ h }``: an affine subspace through ``x0``
along the orthonormal columns of ``B``, and halfspaces in its coordinates ``u`` with unit normals,
some of which may be superfluous. What a radius or a membership needs is read off these; vertices
and facets are found when they are asked for, once the set is known to have an interior in its
subspace.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.analysis.facets import Facets, deepest_point, facets_of, middle_point
from omnimorph.arrays import as_numbers
from omnimorph.errors import OmnimorphError
from omnimorph.protocols import FloatArray

_THIN = 1e-9  # shares of its size: what is nearer to a set than this belongs to it, or is flat


class Sphere(NamedTuple):
    """The inscribed sphere of a set: the largest about a point that lies in it.

    Attributes
    ----------
    radius : float
        In the unit of the set; 0 if the point is outside, or if the set is degenerate.
    direction : (k,) array
        Unit vector towards the facet that it touches: where the set ends first. Across
        the subspace of the set if it is degenerate.
    """

    radius: float
    direction: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Polytope:
    """A bounded convex set of R^k.

    Attributes
    ----------
    origin : (k,) array
        A point of the affine subspace in which the set lies.
    basis : (k, d) array
        Orthonormal directions of that subspace; d = k if the set is not known to be degenerate.
    rows, bounds : (F, d), (F,) arrays
        Halfspaces ``rows u ≤ bounds`` of ``x = origin + basis u``, unit normals; complete, but some
        may be superfluous. `normals` and `offsets` are the irredundant ones, in R^k.
    size : float
        About as large as the coordinates of its points get: what tolerances are shares of.
    void : bool
        True if the set is known to have no point.
    """

    origin: FloatArray
    basis: FloatArray
    rows: FloatArray
    bounds: FloatArray
    size: float
    void: bool = False

    @classmethod
    def bounded_by(
        cls,
        normals: FloatArray,
        offsets: FloatArray,
        origin: FloatArray,
        basis: FloatArray,
        size: float,
    ) -> Self:
        """Build the set of a subspace's points within halfspaces ``normals x ≤ offsets`` of R^k.

        Parameters
        ----------
        normals, offsets : (F, k), (F,) arrays
            Unit normals; halfspaces that hold all of the subspace are left out.
        origin, basis : (k,), (k, d) arrays
            The affine subspace.
        size : float
            As of the set.
        """
        rows = normals @ basis
        bounds = offsets - normals @ origin
        length = np.sqrt(np.einsum("fd,fd->f", rows, rows))
        crossing = length > _THIN
        void = bool((bounds[~crossing] < -_THIN * size).any())
        kept = length[crossing]
        return cls(
            origin=origin,
            basis=basis,
            rows=rows[crossing] / kept[:, None],
            bounds=bounds[crossing] / kept,
            void=void,
            size=size,
        )

    # --- read off the halfspaces --------------------------------------------------------------

    @property
    def n_coordinates(self) -> int:
        """The k of R^k."""
        return len(self.origin)

    def margin(self, point: ArrayLike) -> float:
        """Return how far inside a point is: its distance to the nearest facet, within the subspace.

        Parameters
        ----------
        point : (k,) array
            In the unit of the set.

        Returns
        -------
        float
            Zero on the boundary; negative outside, where the distance to the set is at least as
            much; −inf if the set is empty.
        """
        if self.void:
            return -np.inf
        v = self._as_vector(point) - self.origin
        u = self.basis.T @ v
        off = float(np.linalg.norm(v - self.basis @ u))
        if off > _THIN * self.size:
            return -off
        return float((self.bounds - self.rows @ u).min(initial=np.inf if len(u) else 0.0))

    def contains(self, point: ArrayLike) -> bool:
        """Return whether a point belongs to the set or its boundary (to 1e-9 of its size)."""
        return self.margin(point) >= -_THIN * self.size

    def inscribed_sphere(self, centre: ArrayLike | None = None) -> Sphere:
        """Return the inscribed sphere about a point, by default zero, and where it touches.

        Its radius is the least distance to a halfspace, so it is exact, and superfluous halfspaces
        do not matter. At a distance that several facets share, the direction is one of theirs.
        """
        k, d = self.basis.shape
        if d < k or self.void:
            return Sphere(0.0, _across(self.basis))
        point = np.zeros(k) if centre is None else self._as_vector(centre)
        slack = self.bounds - self.rows @ (self.basis.T @ (point - self.origin))
        nearest = int(slack.argmin())
        return Sphere(max(float(slack[nearest]), 0.0), self.basis @ self.rows[nearest])

    @property
    def inscribed_radius(self) -> float:
        """Radius of the inscribed sphere about the zero vector; 0 if that is outside."""
        return self.inscribed_sphere().radius

    def reach(self, direction: ArrayLike) -> float:
        """Return the largest t ≥ 0 for which t times a direction is in the set; 0 if none is.

        For a unit vector it is the largest force (or torque) along it, exact; the direction need
        not be one.

        Examples
        --------
        At 60° of tilt OmniMorph pushes with up to 2 √3 f_max = 18.56 N along x with free moments,
        where straight up it has 8 · 0.5 f_max = 21.43 N.
        """
        return self.stretch(direction)[1]

    def stretch(self, direction: ArrayLike) -> tuple[float, float]:
        """Return the least and the largest t ≥ 0 for which t times a direction is in the set.

        All between them are, too. Both are 0 if none is. The least is above 0 where rotors cannot
        turn slowly enough: they push at least so much.
        """
        towards = self._as_vector(direction)
        along = self.basis.T @ towards
        on_flat = self._is_beside(np.zeros(self.n_coordinates))
        length = float(np.linalg.norm(towards))
        off = float(np.linalg.norm(towards - self.basis @ along))
        if self.void or on_flat or off > _THIN * length:
            return 0.0, 0.0
        start = self.bounds + self.rows @ (self.basis.T @ self.origin)
        speed = self.rows @ along
        ahead, behind = speed > 0.0, speed < 0.0
        last = float((start[ahead] / speed[ahead]).min(initial=np.inf))
        first = float((start[behind] / speed[behind]).max(initial=0.0))
        beside = bool((start[~ahead & ~behind] < -_THIN * self.size).any())
        slip = _THIN * max(last, 0.0)
        if beside or first > last + slip or not np.isfinite(last):
            return 0.0, 0.0
        if last * length <= _THIN * self.size:  # zero, but for rounding
            return 0.0, 0.0
        return min(first, max(last, 0.0)), max(last, 0.0)

    # --- what needs an interior ---------------------------------------------------------------

    @property
    def is_empty(self) -> bool:
        """True if no point belongs to the set."""
        return self._body.void

    @property
    def dimension(self) -> int:
        """Of the set: 3 for a solid, 2 for a plane, 1 for a line, 0 for a point, −1 if empty."""
        return -1 if self.is_empty else self._body.basis.shape[1]

    @property
    def vertices(self) -> FloatArray:
        """The corners: (V, k) array, in the unit of the set; in order around a plane or a line.

        Raises
        ------
        OmnimorphError
            For sets of more than three dimensions, which have very many.
        """
        body = self._body
        return body.origin + self._facets.vertices @ body.basis.T

    @property
    def normals(self) -> FloatArray:
        """Outward unit normals of the facets, (F, k); then ± those across a degenerate set.

        With `offsets` they say exactly what the set is: ``normals x ≤ offsets``.
        """
        across = _complement(self._body.basis).T
        return np.vstack([self._facets.rows @ self._body.basis.T, across, -across])

    @property
    def offsets(self) -> FloatArray:
        """Distances of the facets from the zero vector along `normals`: (F,) array."""
        body, corners = self._body, self._facets
        facets = corners.bounds + corners.rows @ (body.basis.T @ body.origin)
        across = _complement(body.basis).T @ body.origin
        return np.concatenate([facets, across, -across])

    @cached_property
    def facets(self) -> tuple[NDArray[np.int64], ...]:
        """The polygons that bound a solid: indices of `vertices`, counter-clockwise from outside.

        A plane is one polygon; a line, a point and an empty set have none.
        """
        if self.dimension == 2:
            return (np.arange(len(self._facets.vertices)),)
        mirrored = self.dimension == 3 == self.n_coordinates and np.linalg.det(self._body.basis) < 0
        return tuple(polygon[:: -1 if mirrored else 1] for polygon in self._facets.polygons)

    @cached_property
    def volume(self) -> float:
        """In the cube of the set's unit (N³ for forces); 0 for a degenerate or empty set."""
        if self.dimension < self.n_coordinates:
            return 0.0
        corners = self._facets.vertices
        spokes = corners - corners.mean(axis=0)
        pyramids = [
            spokes[first] @ np.cross(spokes[rest[:-1]], spokes[rest[1:]]).sum(axis=0)
            for first, *rest in self._facets.polygons
        ]
        return float(sum(pyramids) / 6.0)

    def support(self, direction: ArrayLike) -> float:
        """Return max d·x over the set: how far it extends along a direction; −inf if empty."""
        if self.is_empty:
            return -np.inf
        return float((self.vertices @ self._as_vector(direction)).max())

    # --- inside -------------------------------------------------------------------------------

    @cached_property
    def _body(self) -> Polytope:
        """The same set, in a subspace in which it has an interior; its origin is well inside."""
        body: Polytope = self
        thin = _THIN * self.size
        while not body.void and body.basis.shape[1]:
            inner, depth = np.zeros(body.basis.shape[1]), float(body.bounds.min())
            if depth <= thin:
                inner, depth, tight = deepest_point(body.rows, body.bounds, self.size)
            if depth < -thin:
                return nowhere(self.n_coordinates, self.size)
            if depth > thin:
                inner = inner + middle_point(body.rows, body.bounds - body.rows @ inner)
                return _about(body, inner)
            if len(tight):
                body = _within(body, tight)
            else:  # as round as a point is, and no larger
                body = _point(body.origin + body.basis @ inner, self.size)
        return nowhere(self.n_coordinates, self.size) if body.void else body

    @cached_property
    def _facets(self) -> Facets:
        body = self._body
        d = body.basis.shape[1]
        if d > 3:
            raise OmnimorphError(
                "vertices are listed of sets of at most three dimensions; use support()."
            )
        if body.void:
            return Facets(np.empty((0, d)), body.rows, body.bounds)
        return facets_of(body.rows, body.bounds)

    def _is_beside(self, point: FloatArray) -> bool:
        """Return whether a point lies beside the subspace of the set."""
        v = point - self.origin
        off = float(np.linalg.norm(v - self.basis @ (self.basis.T @ v)))
        return off > _THIN * self.size

    def _as_vector(self, value: ArrayLike) -> FloatArray:
        vector = as_numbers(value)
        if vector.shape != (self.n_coordinates,) or not np.isfinite(vector).all():
            raise OmnimorphError(f"{value!r} is not a vector of {self.n_coordinates} numbers.")
        return vector


@dataclass(frozen=True, eq=False, kw_only=True)
class Zonotope(Polytope):
    """The image of a box under a linear map: ``{ centre + Σ t_i g_i : |t_i| ≤ 1 }``.

    Attributes
    ----------
    centre : (k,) array
        Its centre of symmetry.
    generators : (k, n) array
        The columns g_i.
    """

    centre: FloatArray
    generators: FloatArray

    @cached_property
    def _body(self) -> Polytope:
        return self  # its origin is its centre, and its rank has been found exactly

    def support(self, direction: ArrayLike) -> float:
        """Return max d·x = d·c + Σ |d·g_i| over the set, in closed form."""
        d = self._as_vector(direction)
        return float(d @ self.centre + np.abs(d @ self.generators).sum())


def nowhere(k: int, size: float) -> Polytope:
    """Return the empty set of R^k, for thrusts of this size."""
    return replace(_point(np.zeros(k), size), void=True)


def _point(origin: FloatArray, size: float) -> Polytope:
    return Polytope(
        origin=origin,
        basis=np.empty((len(origin), 0)),
        rows=np.empty((0, 0)),
        bounds=np.empty(0),
        size=size,
    )


def _about(body: Polytope, inner: FloatArray) -> Polytope:
    """Return the same set with that point as the origin of its subspace."""
    return replace(
        body, origin=body.origin + body.basis @ inner, bounds=body.bounds - body.rows @ inner
    )


def _within(body: Polytope, tight: NDArray[np.int64]) -> Polytope:
    """Return a degenerate set in the subspace on which these halfspaces hold as equations."""
    rows, bounds = body.rows[tight], body.bounds[tight]
    U, S, Vt = np.linalg.svd(rows)
    rank = max(int((1e-7 * S[0] < S).sum()), 1)
    inner = Vt[:rank].T @ ((U[:, :rank].T @ bounds) / S[:rank])
    origin = body.origin + body.basis @ inner
    basis = body.basis @ Vt[rank:].T
    normals = body.rows @ body.basis.T
    offsets = body.bounds + normals @ body.origin
    others = np.setdiff1d(np.arange(len(normals)), tight)
    return Polytope.bounded_by(normals[others], offsets[others], origin, basis, body.size)


def _complement(basis: FloatArray) -> FloatArray:
    """Return orthonormal directions across a subspace, (k, k − d)."""
    k, d = basis.shape
    if d == 0:
        return np.eye(k)
    return np.linalg.svd(basis)[0][:, d:]


def _across(basis: FloatArray) -> FloatArray:
    """Return a unit vector across a subspace; any unit vector if it is all of the space."""
    across = _complement(basis)
    return across[:, -1] if across.shape[1] else np.eye(len(basis))[-1]
