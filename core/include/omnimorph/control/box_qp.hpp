// The small dense box QP: minimise x'Hx/2 + g'x over lower <= x <= upper, H symmetric positive definite.
//
// First by block principal pivoting (J. J. Júdice, F. M. Pires, "A block principal pivoting algorithm for large-scale
// strictly monotone linear complementarity problems", Computers & OR 21, 1994); one exchange:
//   1. fix the variables of the active set at their bounds and solve for the free ones (LDL'),
//   2. take the gradient, the multipliers of the bounds,
//   3. exchange every variable that violates its bound or the sign of its multiplier; stop when there is none.
// A warm start is nearly always right at once. In the rare problem that has not converged after a few exchanges, a
// primal active-set method goes on (J. Nocedal, S. J. Wright, "Numerical Optimization", Sec. 16.5), whose cost falls in
// every step. The answer is exact for its active set; the KKT residual proves it.
#pragma once

#include "../model/vehicle.hpp"

namespace omnimorph {

/// One number for each variable: thrusts, or tilts. N is their number, or 0 if it is counted at run time.
template <class T, int N> struct PerVariable {
    T a[N > 0 ? N : (most_rotors > most_servos ? most_rotors : most_servos)];
    OMNIMORPH_FN T& operator[](int i) { return a[i]; }
    OMNIMORPH_FN const T& operator[](int i) const { return a[i]; }
};

/// The lower triangle of a symmetric matrix, or of its factors LDL': L, and on its diagonal D⁻¹.
template <class T, int N> using Triangle = PerVariable<PerVariable<T, N>, N>;

template <class T, int N> struct BoxQp {
    Count<N> n;
    Triangle<T, N> H;
    PerVariable<T, N> g, lower, upper;
    Triangle<T, N> factors;    // of H, made when they are first needed
    bool is_factored = false;  // to be unset by whoever changes H
};

template <class T, int N> struct BoxQpSolution {
    PerVariable<T, N> x;
    PerVariable<T, N> active;  // -1 at the lower bound, 0 free, +1 at the upper bound; on entry: where to start
    T kkt_residual;            // max_i |x - clamp(x - (Hx + g))|
    int iterations;            // systems solved, until the slowest lane had converged
};

/// In the place of factors that are not needed.
struct NoFactors {};

namespace box_qp {

template <class T> inline constexpr double tolerance = is_double<T> ? 1e-13 : 1e-5;
template <class T> inline constexpr double proven = is_double<T> ? 1e-9 : 1e-4;  // by this residual
inline constexpr int max_exchanges = 10;
inline constexpr int max_steps = 400;

/// Whether any variable of any lane is at a bound.
template <class T, int N> OMNIMORPH_FN bool any_active(const PerVariable<T, N>& active, int n) {
    T bounds = T(0);
    for (int i = 0; i < n; ++i) bounds += abs(active[i]);
    return any(bounds > T(0));
}

/// H with the rows and columns of the identity in the place of those of the active variables.
template <class T, int N>
OMNIMORPH_FN Triangle<T, N> reduced_hessian(const BoxQp<T, N>& qp, const PerVariable<T, N>& active) {
    Triangle<T, N> K;
    for (int i = 0; i < qp.n; ++i) {
        const Mask<T> row_free = active[i] == T(0);
        for (int j = 0; j <= i; ++j) {
            const Mask<T> column_free = active[j] == T(0);
            K[i][j] = select(row_free & column_free, qp.H[i][j], T(i == j ? 1 : 0));
        }
    }
    return K;
}

/// The right side that goes with it: y, on entry -g, becomes that of the free variables, and for an active one its
/// bound.
template <class T, int N>
OMNIMORPH_FN void fix_active(const BoxQp<T, N>& qp, const PerVariable<T, N>& active, PerVariable<T, N>& y) {
    PerVariable<T, N> bound;
    for (int i = 0; i < qp.n; ++i) {
        const T at = select(active[i] < T(0), qp.lower[i], qp.upper[i]);
        bound[i] = select(active[i] == T(0), T(0), at);
    }
    for (int i = 0; i < qp.n; ++i) {
        for (int j = 0; j < qp.n; ++j) y[i] -= (j < i ? qp.H[i][j] : qp.H[j][i]) * bound[j];
        y[i] = select(active[i] == T(0), y[i], bound[i]);
    }
}

/// LDL' of K, row by row, so that a number is written once, when it is final, and into a matrix that nothing else can
/// write to; unrolled, because the compilers leave triangular loops rolled and the time goes here.
template <class T, int N> OMNIMORPH_FN Triangle<T, N> factors_of(const Triangle<T, N>& K, Count<N> count) {
    const int n = count;
    Triangle<T, N> L;
#pragma GCC unroll 8
    for (int i = 0; i < n; ++i) {
        PerVariable<T, N> row;  // i of L D
#pragma GCC unroll 8
        for (int j = 0; j < i; ++j) {
            T sum = K[i][j];
#pragma GCC unroll 8
            for (int k = 0; k < j; ++k) sum -= row[k] * L[j][k];
            row[j] = sum;
        }
        T pivot = K[i][i];
#pragma GCC unroll 8
        for (int j = 0; j < i; ++j) {
            L[i][j] = row[j] * L[j][j];
            pivot -= row[j] * L[i][j];
        }
        L[i][i] = T(1) / pivot;
    }
    return L;
}

/// x of LDL' x = y.
template <class T, int N>
OMNIMORPH_FN void substitute(const Triangle<T, N>& L, PerVariable<T, N> y, PerVariable<T, N>& x, Count<N> count) {
    const int n = count;
#pragma GCC unroll 8
    for (int j = 0; j < n; ++j) {
#pragma GCC unroll 8
        for (int i = j + 1; i < n; ++i) y[i] -= L[i][j] * y[j];
    }
#pragma GCC unroll 8
    for (int i = 0; i < n; ++i) y[i] = y[i] * L[i][i];
#pragma GCC unroll 8
    for (int j = n - 1; j >= 0; --j) {
        x[j] = y[j];
#pragma GCC unroll 8
        for (int i = 0; i < j; ++i) y[i] -= L[j][i] * y[j];
    }
}

/// x on the active set: bounds where active, the minimiser over the rest elsewhere. Where nothing is active the factors
/// are those of H, which serve every problem with the same H. `factors` receives those of the system solved, unless
/// NoFactors.
template <class T, int N, class Factors>
OMNIMORPH_FN void solve_free(BoxQp<T, N>& qp, BoxQpSolution<T, N>& s, Factors& factors) {
    PerVariable<T, N> y;
    for (int i = 0; i < qp.n; ++i) y[i] = -qp.g[i];
    Triangle<T, N> reduced;
    const Triangle<T, N>* used = &qp.factors;
    if (any_active(s.active, qp.n)) {
        fix_active(qp, s.active, y);
        reduced = factors_of(reduced_hessian(qp, s.active), qp.n);
        used = &reduced;
    } else if (!qp.is_factored) {
        qp.factors = factors_of(qp.H, qp.n);
        qp.is_factored = true;
    }
    substitute(*used, y, s.x, qp.n);
    if constexpr (!std::is_same_v<Factors, NoFactors>) factors = *used;
}

template <class T, int N> OMNIMORPH_FN PerVariable<T, N> gradient(const BoxQp<T, N>& qp, const PerVariable<T, N>& x) {
    PerVariable<T, N> gradient;
    for (int i = 0; i < qp.n; ++i) {
        gradient[i] = qp.g[i] + qp.H[i][i] * x[i];
#pragma GCC unroll 8
        for (int j = 0; j < i; ++j) {
            gradient[i] += qp.H[i][j] * x[j];
            gradient[j] += qp.H[i][j] * x[i];
        }
    }
    return gradient;
}

/// Where each variable should be instead: the active set after exchanging every violation.
template <class T, int N>
OMNIMORPH_FN PerVariable<T, N> corrected_active_set(const BoxQp<T, N>& qp, const BoxQpSolution<T, N>& s,
                                                    const PerVariable<T, N>& multiplier) {
    PerVariable<T, N> corrected;
    for (int i = 0; i < qp.n; ++i) {
        const T a = s.active[i];
        const Mask<T> below = s.x[i]<qp.lower[i] - T(tolerance<T>), above = s.x[i]> qp.upper[i] + T(tolerance<T>);
        const T outside = select(below, T(-1), select(above, T(1), T(0)));
        const T held = select(a * multiplier[i] > T(tolerance<T>), T(0), a);
        corrected[i] = select(a == T(0), outside, held);
    }
    return corrected;
}

template <class T, int N>
OMNIMORPH_FN T kkt_residual(const BoxQp<T, N>& qp, const PerVariable<T, N>& x, const PerVariable<T, N>& gradient) {
    T residual = T(0);
    for (int i = 0; i < qp.n; ++i) {
        residual = max_or_nan(residual, abs(x[i] - clamp(x[i] - gradient[i], qp.lower[i], qp.upper[i])));
    }
    return residual;
}

/// Block principal pivoting; true in the lanes that converged. Such a lane repeats its answer while the others go on.
template <class T, int N, class Factors>
OMNIMORPH_FN Mask<T> block_principal_pivoting(BoxQp<T, N>& qp, BoxQpSolution<T, N>& s, Factors& factors) {
    for (s.iterations = 1;; ++s.iterations) {
        solve_free(qp, s, factors);
        const PerVariable<T, N> multiplier = gradient(qp, s.x);
        const PerVariable<T, N> corrected = corrected_active_set(qp, s, multiplier);
        Mask<T> converged = T(0) == T(0);
        for (int i = 0; i < qp.n; ++i) converged = converged & (corrected[i] == s.active[i]);
        if (all(converged) || s.iterations == max_exchanges) {
            s.kkt_residual = kkt_residual(qp, s.x, multiplier);
            return converged;
        }
        s.active = corrected;
    }
}

/// The ratio test: how far x may go towards the target, 1 being the target itself, until a first variable reaches its
/// bound; `ratio` is how far each may go.
template <class T, int N>
OMNIMORPH_FN T ratio_test(const BoxQp<T, N>& qp, const PerVariable<T, N>& x, const PerVariable<T, N>& target,
                          PerVariable<T, N>& ratio) {
    T least = T(1);
    for (int i = 0; i < qp.n; ++i) {
        const T bound = select(target[i] < x[i], qp.lower[i], qp.upper[i]);
        const Mask<T> stays = target[i] == x[i], is_long = abs(target[i] - x[i]) > abs(bound - x[i]);
        const Mask<T> beyond = is_long & !stays;
        ratio[i] = select(beyond, (bound - x[i]) / select(beyond, target[i] - x[i], T(1)), T(2));
        least = min(least, ratio[i]);
    }
    return least;
}

/// Primal active set: walk towards the minimiser over the free variables until a bound stops it; where none does, free
/// the variable whose multiplier has the wrong sign most. Lanes that have `converged` stay where they are.
template <class T, int N, class Factors>
OMNIMORPH_FN void primal_active_set(BoxQp<T, N>& qp, BoxQpSolution<T, N>& s, Factors& factors, Mask<T> converged) {
    PerVariable<T, N> x;
    for (int i = 0; i < qp.n; ++i) {
        x[i] = clamp(s.x[i], qp.lower[i], qp.upper[i]);
        const T at_bound = select(x[i] <= qp.lower[i], T(-1), select(x[i] >= qp.upper[i], T(1), T(0)));
        s.active[i] = select(converged, s.active[i], at_bound);
    }
    for (const int last = s.iterations + max_steps; any(!converged) && s.iterations < last; ++s.iterations) {
        solve_free(qp, s, factors);
        PerVariable<T, N> ratio;
        const T step = ratio_test(qp, x, s.x, ratio);
        for (int i = 0; i < qp.n; ++i) {
            const T bound = select(s.x[i] < x[i], qp.lower[i], qp.upper[i]);
            const Mask<T> stopped = (ratio[i] <= step) & !converged;
            s.active[i] = select(stopped, select(s.x[i] < x[i], T(-1), T(1)), s.active[i]);
            x[i] = select(stopped, bound, select(step < T(1), x[i] + step * (s.x[i] - x[i]), s.x[i]));
        }
        const PerVariable<T, N> multiplier = gradient(qp, x);
        T worst = T(tolerance<T>);
        for (int i = 0; i < qp.n; ++i) worst = max(worst, s.active[i] * multiplier[i]);
        const Mask<T> arrived = !(step < T(1));
        converged = converged | (arrived & (worst <= T(tolerance<T>)));
        for (int i = 0; i < qp.n; ++i) {
            const Mask<T> freed = (arrived & !converged) & (s.active[i] * multiplier[i] >= worst);
            s.active[i] = select(freed, T(0), s.active[i]);
        }
        s.kkt_residual = kkt_residual(qp, x, multiplier);
    }
    s.x = x;
}

}  // namespace box_qp

/// Solve, starting from the active set that `s` brings; `factors` receives those of H over the variables that are free
/// at the end, with the identity elsewhere.
template <class T, int N, class Factors>
OMNIMORPH_FN void solve(BoxQp<T, N>& qp, BoxQpSolution<T, N>& s, Factors& factors) {
    const Mask<T> converged = box_qp::block_principal_pivoting(qp, s, factors);
    if (any(!converged)) box_qp::primal_active_set(qp, s, factors, converged);
    for (int i = 0; i < qp.n; ++i) s.x[i] = clamp(s.x[i], qp.lower[i], qp.upper[i]);
}
template <class T, int N> OMNIMORPH_FN void solve(BoxQp<T, N>& qp, BoxQpSolution<T, N>& s) {
    NoFactors none;
    solve(qp, s, none);
}

}  // namespace omnimorph
