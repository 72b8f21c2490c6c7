// The facets of a bounded convex set { x in R³ : n_k·x <= h_k }, each as the polygon of its corners.
//
// A large cube is cut by one halfspace after another. Whether a corner is cut off is decided once for all polygons that
// meet there, and a new corner belongs to the edge on which it lies, so the polygons always fit together, also where
// many planes meet in a corner and where planes are nearly parallel: what is decided wrongly is nearer than the
// tolerance.
#pragma once

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "../math/matrix.hpp"

namespace omnimorph {

struct Facets {
    std::vector<Vec3<double>> corners;
    std::vector<std::vector<int>> polygons;  // corners, counter-clockwise seen from outside
    std::vector<int> halfspace;              // which halfspace each polygon lies on
};

namespace facets {

inline constexpr double beyond = 1e3;        // half the side of the cube, for sets about as large as 1
inline constexpr double tolerance = 1e-10;   // a corner this near to a plane lies on it
inline constexpr double same_corner = 1e-8;  // the ends of a shorter edge are one corner

OMNIMORPH_FN Facets cube() {
    Facets out;
    for (int k = 0; k < 8; ++k) {
        const Vec3<double> corner = {{k & 1 ? beyond : -beyond, k & 2 ? beyond : -beyond, k & 4 ? beyond : -beyond}};
        out.corners.push_back(corner);
    }
    out.polygons = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    out.halfspace.assign(6, -1);
    return out;
}

/// Leave out the corners that have been cut off.
OMNIMORPH_FN void forget_lost_corners(Facets& set) {
    std::vector<int> renumbered(set.corners.size(), -1);
    std::vector<Vec3<double>> corners;
    for (std::vector<int>& polygon : set.polygons)
        for (int& k : polygon) {
            int& number = renumbered[static_cast<std::size_t>(k)];
            if (number < 0) {
                number = static_cast<int>(corners.size());
                corners.push_back(set.corners[static_cast<std::size_t>(k)]);
            }
            k = number;
        }
    set.corners = std::move(corners);
}

/// Leave out the polygons that are none any more.
OMNIMORPH_FN void forget_lost_polygons(Facets& set) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < set.polygons.size(); ++i) {
        if (set.polygons[i].size() < 3) continue;
        set.halfspace[kept] = set.halfspace[i];
        if (kept != i) set.polygons[kept] = std::move(set.polygons[i]);
        ++kept;
    }
    set.polygons.resize(kept);
    set.halfspace.resize(kept);
}

/// Sets of corners that edges connect.
class Groups {
  public:
    explicit Groups(std::size_t corners) : parent_(corners) { std::iota(parent_.begin(), parent_.end(), 0); }

    int of(int k) {
        while (parent_[static_cast<std::size_t>(k)] != k) k = parent_[static_cast<std::size_t>(k)];
        return k;
    }

    /// Join the ends of each edge for which `belong(from, to)`.
    template <class Belong> void join_ends(const std::vector<std::vector<int>>& polygons, Belong belong) {
        for (const std::vector<int>& polygon : polygons)
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                const int from = polygon[k], to = polygon[(k + 1) % polygon.size()];
                if (belong(from, to)) parent_[static_cast<std::size_t>(of(from))] = of(to);
            }
    }

  private:
    std::vector<int> parent_;
};

/// What happens when a set is cut along n·x = h and what lies beyond is taken away.
class Cut {
  public:
    Cut(Facets& set, const Vec3<double>& n, double h) : set_(set) {
        for (const Vec3<double>& x : set.corners) above_.push_back(dot(n, x) - h);
    }

    void apply(int halfspace) {
        if (std::none_of(above_.begin(), above_.end(), [](double a) { return a > tolerance; })) return;
        choose();
        for (std::vector<int>& polygon : set_.polygons) polygon = rest_of(polygon);
        forget_lost_polygons(set_);
        close(halfspace);
        forget_lost_corners(set_);
    }

  private:
    bool is_out(int k) const { return out_[static_cast<std::size_t>(k)]; }
    bool is_in(int k) const { return !is_out(k) && above_[static_cast<std::size_t>(k)] < -tolerance; }

    /// Choose the corners to cut off: all in one piece, and what stays too, so that the cut is one polygon.
    void choose() {
        const auto [lowest, highest] = std::minmax_element(above_.begin(), above_.end());
        const int deepest = static_cast<int>(lowest - above_.begin()),
                  farthest = static_cast<int>(highest - above_.begin());
        Groups lost(above_.size()), left(above_.size());
        const auto is_beyond = [&](int k) { return above_[static_cast<std::size_t>(k)] > tolerance; };
        lost.join_ends(set_.polygons, [&](int a, int b) { return is_beyond(a) && is_beyond(b); });
        for (int k = 0; k < static_cast<int>(above_.size()); ++k)
            out_.push_back(is_beyond(k) && lost.of(k) == lost.of(farthest));
        left.join_ends(set_.polygons, [&](int a, int b) { return !is_out(a) && !is_out(b); });
        for (int k = 0; k < static_cast<int>(above_.size()); ++k)
            out_[static_cast<std::size_t>(k)] = left.of(k) != left.of(deepest);
    }

    /// What is left of a polygon; the edge along which it is cut becomes one of the new polygon.
    std::vector<int> rest_of(const std::vector<int>& polygon) {
        std::vector<int> rest;
        std::vector<bool> follows_gap;
        bool gap = false;
        const auto keep = [&](int corner) {
            rest.push_back(corner);
            follows_gap.push_back(gap);
            gap = false;
        };
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const int from = polygon[k], to = polygon[(k + 1) % polygon.size()];
            if (is_out(from))
                gap = true;
            else
                keep(from);
            if (is_out(from) ? is_in(to) : is_in(from) && is_out(to)) keep(corner_between(from, to));
        }
        if (!rest.empty() && gap) follows_gap[0] = true;
        for (std::size_t k = 0; k < rest.size(); ++k) {
            const int before = rest[(k + rest.size() - 1) % rest.size()];
            if (follows_gap[k] && before != rest[k]) next_[rest[k]] = before;
        }
        return rest;
    }

    int corner_between(int from, int to) {
        const auto [place, is_new] = between_.try_emplace(std::minmax(from, to), static_cast<int>(set_.corners.size()));
        if (is_new) {
            const auto [a, b] = place->first;
            const double at_a = above_[static_cast<std::size_t>(a)], at_b = above_[static_cast<std::size_t>(b)];
            const Vec3<double>&x = set_.corners[static_cast<std::size_t>(a)],
                  &y = set_.corners[static_cast<std::size_t>(b)];
            const Vec3<double> corner = x + std::clamp(at_a / (at_a - at_b), 0.0, 1.0) * (y - x);
            set_.corners.push_back(corner);
        }
        return place->second;
    }

    /// Add the polygon of the new edges.
    void close(int halfspace) {
        while (!next_.empty()) {
            std::vector<int> polygon;
            for (auto edge = next_.begin(); edge != next_.end(); edge = next_.find(polygon.back())) {
                if (polygon.empty()) polygon.push_back(edge->first);
                polygon.push_back(edge->second);
                next_.erase(edge);
            }
            polygon.pop_back();
            if (polygon.size() < 3) continue;
            set_.polygons.push_back(polygon);
            set_.halfspace.push_back(halfspace);
        }
    }

    Facets& set_;
    std::vector<double> above_;
    std::vector<bool> out_;
    std::map<std::pair<int, int>, int> between_;
    std::map<int, int> next_;  // from each corner of the new polygon to the next one
};

/// Shrink edges too short to mean anything to a corner, and leave out what is no polygon or no corner without them.
OMNIMORPH_FN void tidy(Facets& set) {
    Groups same(set.corners.size());
    same.join_ends(set.polygons, [&](int a, int b) {
        const Vec3<double> apart = set.corners[static_cast<std::size_t>(a)] - set.corners[static_cast<std::size_t>(b)];
        return dot(apart, apart) < same_corner * same_corner;
    });
    for (bool changed = true; changed;) {
        std::vector<int> meeting(set.corners.size(), 0);  // polygons at each corner
        for (std::vector<int>& polygon : set.polygons) {
            std::vector<int> rest;
            for (const int k : polygon)
                if (rest.empty() || rest.back() != same.of(k)) rest.push_back(same.of(k));
            while (rest.size() > 1 && rest.front() == rest.back()) rest.pop_back();
            if (rest.size() < 3) rest.clear();
            for (const int k : rest) ++meeting[static_cast<std::size_t>(k)];
            polygon = std::move(rest);
        }
        changed = false;
        for (std::vector<int>& polygon : set.polygons) {
            const auto is_none = [&](int k) { return meeting[static_cast<std::size_t>(k)] < 3; };
            const auto end = std::remove_if(polygon.begin(), polygon.end(), is_none);
            changed |= end != polygon.end();
            polygon.erase(end, polygon.end());
        }
    }
    forget_lost_polygons(set);
    forget_lost_corners(set);
}

}  // namespace facets

/// Unit normals and distances, all positive: zero is inside, and the set is about as large as 1 in every direction.
OMNIMORPH_FN Facets facets_of(const std::vector<Vec3<double>>& normals, const std::vector<double>& distances) {
    std::vector<std::size_t> nearest_first(normals.size());
    std::iota(nearest_first.begin(), nearest_first.end(), std::size_t{0});
    std::stable_sort(nearest_first.begin(), nearest_first.end(),
                     [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
    Facets out = facets::cube();
    for (const std::size_t k : nearest_first) facets::Cut(out, normals[k], distances[k]).apply(static_cast<int>(k));
    facets::tidy(out);
    return out;
}

}  // namespace omnimorph
