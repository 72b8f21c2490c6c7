// The facets of a bounded convex set { x in R³ : n_k·x <= h_k }, each as the polygon of its corners.
//
// On each plane a large square is cut by all other halfspaces in turn (I. E. Sutherland, G. W. Hodgman, "Reentrant polygon
// clipping", Comm. ACM 17, 1974); what is left is the facet, or nothing if the halfspace is superfluous. Nearly parallel
// planes and corners at which many planes meet do no harm: a wrong decision within the tolerance moves a corner by as
// little. Corners of different polygons that are as near as that are one corner.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "matrix.hpp"

namespace omnimorph {

struct Facets {
    std::vector<Vec3<double>> corners;
    std::vector<std::vector<int>> polygons;  // corners, counter-clockwise seen from outside
    std::vector<int> halfspace;              // which halfspace each polygon lies on
};

namespace facets {

inline constexpr double beyond = 1e3;      // half the side of the square, for sets about as large as 1
inline constexpr double tolerance = 1e-12;
inline constexpr double same_plane = 1e-8, same_corner = 1e-7;  // nearer than this they are one

using Polygon = std::vector<Vec3<double>>;

/// A large square on the plane n·x = h.
inline Polygon square_on(const Vec3<double>& n, double h) {
    Vec3<double> axis = Vec3<double>::zero();
    int least = 0;
    for (int r = 1; r < 3; ++r)
        if (magnitude(n[r]) < magnitude(n[least])) least = r;
    axis[least] = 1.0;
    Vec3<double> u = cross(n, axis);
    u = (beyond / square_root(dot(u, u))) * u;
    const Vec3<double> v = cross(n, u), middle = h * n;
    return {middle - u - v, middle + u - v, middle + u + v, middle - u + v};
}

/// Cut off what lies beyond n·x = h; `kept` is scratch.
inline void clip(Polygon& polygon, const Vec3<double>& n, double h, Polygon& kept) {
    kept.clear();
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3<double>&from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
        const double a = dot(n, from) - h, b = dot(n, to) - h;
        if (a <= tolerance) kept.push_back(from);
        if ((a > tolerance && b < -tolerance) || (a < -tolerance && b > tolerance)) kept.push_back(from + (a / (a - b)) * (to - from));
    }
    polygon.swap(kept);
}

inline bool is_same(const Vec3<double>& x, const Vec3<double>& y) { return dot(x - y, x - y) <= same_corner * same_corner; }

/// The index of a corner, a new one if it is not there yet.
inline int corner_at(std::vector<Vec3<double>>& corners, const Vec3<double>& x) {
    for (std::size_t k = 0; k < corners.size(); ++k)
        if (is_same(corners[k], x)) return static_cast<int>(k);
    corners.push_back(x);
    return static_cast<int>(corners.size()) - 1;
}

}  // namespace facets

namespace facets {

/// The halfspaces, nearest first, without those that repeat another one: a chain of repetitions leaves its first.
inline std::vector<std::size_t> different_planes(const std::vector<Vec3<double>>& normals, const std::vector<double>& distances) {
    std::vector<std::size_t> nearest_first(normals.size()), kept;
    std::iota(nearest_first.begin(), nearest_first.end(), std::size_t{0});
    std::stable_sort(nearest_first.begin(), nearest_first.end(), [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
    for (const std::size_t i : nearest_first) {
        const auto repeats = [&](std::size_t j) {
            const Vec3<double> apart = normals[i] - normals[j];
            return dot(apart, apart) <= same_plane * same_plane;
        };
        if (std::none_of(kept.begin(), kept.end(), repeats)) kept.push_back(i);
    }
    return kept;
}

}  // namespace facets

/// Unit normals and distances, all positive: zero is inside, and the set is about as large as 1 in every direction.
inline Facets facets_of(const std::vector<Vec3<double>>& normals, const std::vector<double>& distances) {
    using namespace facets;
    const std::vector<std::size_t> planes = different_planes(normals, distances);
    Facets out;
    Polygon polygon, scratch;
    for (const std::size_t i : planes) {
        polygon = square_on(normals[i], distances[i]);
        for (const std::size_t j : planes)
            if (j != i && !polygon.empty()) clip(polygon, normals[j], distances[j], scratch);
        std::vector<int> indices;
        for (const Vec3<double>& x : polygon) {
            const int index = corner_at(out.corners, x);
            if (std::find(indices.begin(), indices.end(), index) == indices.end()) indices.push_back(index);
        }
        if (indices.size() < 3) continue;  // it touches an edge or a corner only
        out.polygons.push_back(indices);
        out.halfspace.push_back(static_cast<int>(i));
    }
    return out;
}

}  // namespace omnimorph
