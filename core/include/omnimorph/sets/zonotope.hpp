// The hyperplanes that bound a zonotope { Σ_k t_k g_k : -1 <= t_k <= 1 }, g_k in R^r.
//
// Every facet of a zonotope is spanned by generators: its normal is at right angles to r - 1 of them, and its distance
// is that of the farthest corner, the support function h(n) = Σ_k |n·g_k| (P. McMullen, "On zonotopes", Trans. AMS 159,
// 1971). So all (r - 1)-subsets are gone through, C(n, r - 1) of them, instead of the 2ⁿ corners. The distance belongs
// to the normal as it came out of the arithmetic, so a halfspace may be superfluous, but it never cuts anything off.
#pragma once

#include <utility>

#include "../math/matrix.hpp"

namespace omnimorph {

namespace zonotope {

/// Below this a pivot of unit vectors counts as zero: the subset does not span a hyperplane.
inline constexpr double smallest_pivot = 1e-12;

/// The unit vector at right angles to R - 1 vectors, by elimination with complete pivoting; false if they are
/// dependent.
template <int R> OMNIMORPH_FN bool common_normal(Vec<double, R> (&rows)[R], Vec<double, R>& normal) {
    int column[R];
    for (int c = 0; c < R; ++c) column[c] = c;
    for (int k = 0; k < R - 1; ++k) {
        int row = k, best = k;
        for (int i = k; i < R - 1; ++i)
            for (int c = k; c < R; ++c)
                if (abs(rows[i][column[c]]) > abs(rows[row][column[best]])) row = i, best = c;
        std::swap(rows[k], rows[row]);
        std::swap(column[k], column[best]);
        const double pivot = rows[k][column[k]];
        if (abs(pivot) < smallest_pivot) return false;
        for (int i = k + 1; i < R - 1; ++i) {
            const double share = rows[i][column[k]] / pivot;
            for (int c = k + 1; c < R; ++c) rows[i][column[c]] -= share * rows[k][column[c]];
        }
    }
    normal[column[R - 1]] = 1.0;
    for (int k = R - 2; k >= 0; --k) {
        double sum = 0.0;
        for (int c = k + 1; c < R; ++c) sum += rows[k][column[c]] * normal[column[c]];
        normal[column[k]] = -sum / rows[k][column[k]];
    }
    normal = (1.0 / sqrt(dot(normal, normal))) * normal;
    return true;
}

}  // namespace zonotope

/// Call `found(normal, h)` for each of the hyperplanes: the zonotope lies between n·x = -h and n·x = h.
template <int R, class Found>
OMNIMORPH_FN void bounding_hyperplanes(const Vec<double, R>* generators, int n, Found found) {
    int chosen[R];  // the last entry stays unused, so that R = 1, the empty subset, has an array too
    for (int k = 0; k < R - 1; ++k) chosen[k] = k;
    if (n < R - 1) return;
    for (;;) {
        Vec<double, R> rows[R], normal;
        for (int k = 0; k < R - 1; ++k) {
            const Vec<double, R>& g = generators[chosen[k]];
            const double length = sqrt(dot(g, g));
            rows[k] = length > 0.0 ? (1.0 / length) * g : g;
        }
        if (zonotope::common_normal<R>(rows, normal)) {
            double support = 0.0;
            for (int k = 0; k < n; ++k) support += abs(dot(normal, generators[k]));
            found(normal, support);
        }
        int last = R - 2;
        while (last >= 0 && chosen[last] == n - (R - 1) + last) --last;
        if (last < 0) return;
        ++chosen[last];
        for (int k = last + 1; k < R - 1; ++k) chosen[k] = chosen[k - 1] + 1;
    }
}

}  // namespace omnimorph
