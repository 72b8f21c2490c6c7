// Pose tracking: the acceleration that leads back to the reference (the paper's eq. 14).
#pragma once

#include "../math/so3.hpp"
#include "../model/motion.hpp"

namespace omnimorph {

template <class T> struct TrackingGains {
    Vec3<T> velocity, position;  // K_p1 in 1/s, K_p2 in 1/s²
    Vec3<T> rate, attitude;      // K_w1 in 1/s, K_w2 in 1/s²

    static constexpr auto fields() {
        using G = TrackingGains;
        return field_list(field("velocity", &G::velocity), field("position", &G::position), field("rate", &G::rate),
                          field("attitude", &G::attitude));
    }
};

/// What is asked of allocation: accelerations, d²p/dt² in W and dw/dt in B.
template <class T> struct Demand {
    Vec6<T> acceleration;
};

template <class T> OMNIMORPH_FN Vec3<T> times_each(const Vec3<T>& x, const Vec3<T>& y) {
    return {{x[0] * y[0], x[1] * y[1], x[2] * y[2]}};
}

/// p̈_r = p̈_d + K_p1 ė_p + K_p2 e_p
template <class T>
OMNIMORPH_FN Vec3<T> linear_acceleration(const Motion<T>& state, const Desired<T>& desired,
                                         const TrackingGains<T>& gains) {
    const Vec3<T> e_p = desired.p - state.p, e_v = desired.v - state.v;
    return desired.a + times_each(gains.velocity, e_v) + times_each(gains.position, e_p);
}

/// q̈_r = [p̈_d + K_p1 ė_p + K_p2 e_p ; feed-forward + K_w1 e_w + K_w2 e_R], with e_R = ½ (RᵀR_d - R_dᵀR)^∨ and
/// e_w = RᵀR_d w_d - w. The desired rate is carried into the vehicle's own frame (the paper leaves this out), which
/// also gives the feed-forward RᵀR_d ẇ_d - w x RᵀR_d w_d.
template <class T>
OMNIMORPH_FN Vec6<T> reference_acceleration(const Motion<T>& state, const Desired<T>& desired,
                                            const TrackingGains<T>& gains) {
    const Mat3<T> R_error = transpose_times(state.R, desired.R);
    const Vec3<T> e_R = vee_of_skew_part(R_error);
    const Vec3<T> w_desired = R_error * desired.w;
    const Vec3<T> e_w = w_desired - state.w;
    const Vec3<T> linear = linear_acceleration(state, desired, gains);
    const Vec3<T> angular = R_error * desired.dw - cross(state.w, w_desired) + times_each(gains.rate, e_w) +
                            times_each(gains.attitude, e_R);
    return {{linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]}};
}

}  // namespace omnimorph
