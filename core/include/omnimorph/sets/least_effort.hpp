// The thrusts that make a wrench with the least effort, within their limits:
//
//     minimise Σ_i phi_i(f_i)   over   A f = w,  lower <= f <= upper,
//
// with phi_i(f) = p_i |f|^(3/2), the rotor drag power (p_i = c_tau / c_f^(3/2)), or phi_i(f) = p_i f² / 2.
//
// Both are strictly convex and a sum over the rotors, so the dual problem (S. Boyd, L. Vandenberghe, "Convex
// Optimization", Sec. 5.5.5) is smooth and has only the r rows of A as variables:
//
//     maximise q(λ) = w·λ - Σ_i phi_i*(s_i),   s = Aᵀλ,   grad q = w - A f(s),   -Hess q = A diag(df/ds) Aᵀ
//
// where f_i(s_i) = argmin phi_i(f) - s_i f within the limits, in closed form. The primal problem itself has no second
// derivative where a rotor stops; the dual has. Newton's steps, damped as Levenberg and Marquardt do where the Hessian
// is flat (rotors at their limits), with a line search on q. Whatever λ it ends with, f(λ) is the exact answer for the
// wrench A f(λ): all that is left to check is w - A f. If no thrusts make w, a direction λ with λ·w > max λ·A f proves
// it (Farkas).
#pragma once

#include "../model/vehicle.hpp"

namespace omnimorph {

enum class Effort { power, norm };

/// The problem; A is given by its columns and its rows are independent, best orthonormal.
template <int R> struct LeastEffort {
    int n;
    Effort effort;
    Vec<double, R> column[most_rotors];
    double price[most_rotors], lower[most_rotors], upper[most_rotors];
};

enum class LeastEffortOutcome { solved, impossible, not_settled };

template <int R> struct LeastEffortSolution {
    double thrust[most_rotors];
    Vec<double, R> multiplier;  // λ: how fast the least effort grows with the wrench
    double residual;            // |w - A f|
    LeastEffortOutcome outcome;
    int iterations;
};

namespace least_effort {

inline constexpr double tolerance = 1e-12;  // of |w - A f|, in shares of |w| or of the columns
inline constexpr int most_iterations = 200;
inline constexpr int most_halvings = 40;

/// f(s), its derivative and phi*(s) of one rotor.
struct Response {
    double f, slope, conjugate;
};
OMNIMORPH_FN Response respond(Effort effort, double price, double lower, double upper, double s) {
    double f, slope;
    if (effort == Effort::power) {
        const double root = s / (1.5 * price);  // |f|^(1/2), signed
        f = root * abs(root);
        slope = 2.0 * abs(root) / (1.5 * price);
    } else {
        f = s / price;
        slope = 1.0 / price;
    }
    if (f <= lower || f >= upper) {
        f = clamp(f, lower, upper);
        slope = 0.0;
    }
    const double phi = effort == Effort::power ? price * abs(f) * sqrt(abs(f)) : 0.5 * price * f * f;
    return {f, slope, s * f - phi};
}

template <int R> struct Dual {
    double value, size;  // q, and the sum of the sizes of its terms, of which rounding errors are shares
    Vec<double, R> gradient;
    double hessian[R][R];  // of -q, its lower triangle
    double thrust[most_rotors];
    double reach;  // max λ·A f: no wrench with λ·w beyond it can be made
};

template <int R>
OMNIMORPH_FN Dual<R> dual_at(const LeastEffort<R>& problem, const Vec<double, R>& w, const Vec<double, R>& multiplier) {
    Dual<R> q;
    q.value = dot(w, multiplier);
    q.size = abs(q.value);
    q.gradient = w;
    q.reach = 0.0;
    for (int r = 0; r < R; ++r)
        for (int c = 0; c <= r; ++c) q.hessian[r][c] = 0.0;
    for (int i = 0; i < problem.n; ++i) {
        const Vec<double, R>& a = problem.column[i];
        const double s = dot(a, multiplier);
        const Response rotor = respond(problem.effort, problem.price[i], problem.lower[i], problem.upper[i], s);
        q.thrust[i] = rotor.f;
        q.value -= rotor.conjugate;
        q.size += abs(rotor.conjugate);
        q.gradient = q.gradient - rotor.f * a;
        q.reach += max(s * problem.lower[i], s * problem.upper[i]);
        for (int r = 0; r < R; ++r)
            for (int c = 0; c <= r; ++c) q.hessian[r][c] += rotor.slope * a[r] * a[c];
    }
    return q;
}

/// (H + damping I)⁻¹ g by Cholesky's factors.
template <int R> OMNIMORPH_FN Vec<double, R> damped_step(const Dual<R>& q, double damping) {
    double L[R][R];
    Vec<double, R> y = q.gradient;
    for (int r = 0; r < R; ++r) {
        for (int c = 0; c <= r; ++c) {
            double sum = q.hessian[r][c] + (r == c ? damping : 0.0);
            for (int k = 0; k < c; ++k) sum -= L[r][k] * L[c][k];
            L[r][c] = r == c ? sqrt(max(sum, damping * 1e-6)) : sum / L[c][c];
        }
        for (int k = 0; k < r; ++k) y[r] -= L[r][k] * y[k];
        y[r] = y[r] / L[r][r];
    }
    for (int r = R - 1; r >= 0; --r) {
        for (int k = r + 1; k < R; ++k) y[r] -= L[k][r] * y[k];
        y[r] = y[r] / L[r][r];
    }
    return y;
}

template <int R> OMNIMORPH_FN double trace(const Dual<R>& q) {
    double sum = 0.0;
    for (int r = 0; r < R; ++r) sum += q.hessian[r][r];
    return sum;
}

/// The problem without limits in which every rotor answers as it does at a middling thrust: where the search starts,
/// and how curved the dual usually is.
template <int R> OMNIMORPH_FN LeastEffort<R> levelled(const LeastEffort<R>& problem) {
    LeastEffort<R> level = problem;
    level.effort = Effort::norm;
    for (int i = 0; i < problem.n; ++i) {
        const double typical = 0.25 * max(abs(problem.lower[i]), abs(problem.upper[i]));
        if (problem.effort == Effort::power) level.price[i] = 1.5 * problem.price[i] / sqrt(typical);
        level.lower[i] = -1e300;
        level.upper[i] = 1e300;
    }
    return level;
}

}  // namespace least_effort

template <int R> OMNIMORPH_FN LeastEffortSolution<R> solve(const LeastEffort<R>& problem, const Vec<double, R>& w) {
    using namespace least_effort;
    const Dual<R> level = dual_at(levelled(problem), w, Vec<double, R>::zero());
    const double usual = trace(level);
    Vec<double, R> multiplier = damped_step(level, 1e-14 * usual);
    Dual<R> q = dual_at(problem, w, multiplier);
    double scale = sqrt(dot(w, w));
    for (int i = 0; i < problem.n; ++i)
        scale = max(
            scale, max(abs(problem.lower[i]), abs(problem.upper[i])) * sqrt(dot(problem.column[i], problem.column[i])));
    LeastEffortSolution<R> s;
    s.outcome = LeastEffortOutcome::not_settled;
    double damping = 1e-3;
    for (s.iterations = 0; s.iterations < most_iterations; ++s.iterations) {
        s.residual = sqrt(dot(q.gradient, q.gradient));
        const double size = sqrt(dot(multiplier, multiplier));
        if (s.residual <= tolerance * scale) {
            s.outcome = LeastEffortOutcome::solved;
            break;
        }
        if (dot(w, multiplier) - q.reach > 1e-9 * scale * size) {
            s.outcome = LeastEffortOutcome::impossible;
            break;
        }
        const Vec<double, R> step = damped_step(q, usual * (min(damping, s.residual / scale) + 1e-16));
        const double slope = dot(q.gradient, step);
        double share = 1.0;
        Dual<R> next;
        bool better = false;
        for (int halving = 0; halving < most_halvings && !better; ++halving, share *= 0.5) {
            next = dual_at(problem, w, multiplier + share * step);
            const double residual = sqrt(dot(next.gradient, next.gradient));
            // at the end rounding hides how q grows, but not how the residual falls
            const bool level = next.value >= q.value - 1e-14 * q.size;
            better = next.value >= q.value + 1e-4 * share * slope ||
                     (level && residual <= (1.0 - 1e-4 * share) * s.residual);
            if (better) multiplier = multiplier + share * step;
        }
        if (!better) break;
        damping = share > 0.3 ? max(0.1 * damping, 1e-12) : min(4.0 * damping, 1e3);
        q = next;
    }
    s.residual = sqrt(dot(q.gradient, q.gradient));
    for (int i = 0; i < problem.n; ++i) s.thrust[i] = q.thrust[i];
    s.multiplier = multiplier;
    return s;
}

}  // namespace omnimorph
