// Position first: where a vehicle cannot push sideways enough in the desired attitude, the attitude gives way.
//
// A vehicle makes forces f with |f - (f·z) z| <= r about its body axis z: r is 0 for parallel rotors. So the force that
// the trajectory asks for must lie within asin(r / |f|) of z. If the desired attitude does not do that, it is turned
// about z x f, by as little as is needed (A. Franchi, R. Carli, D. Bicego, M. Ryll, "Full-pose tracking control for
// aerial robotic systems with laterally bounded input force", IEEE Trans. Robotics 34, 2018).
#pragma once

#include "tracking.hpp"

namespace omnimorph {

template <class T> struct PositionFirst {
    bool active = false;
    T lateral_force = T(0);  // r, N
    T mass = T(0);           // kg, of the model
    T period = T(0);         // of control, s

    static constexpr auto fields() {
        using P = PositionFirst;
        return field_list(derived("active", &P::active), field("lateral_force", &P::lateral_force),
                          derived("mass", &P::mass), derived("period", &P::period));
    }
};

/// The least rotation that turns the unit vector a into the unit vector b: I + [v]x + [v]x² / (1 + a·b), v = a x b.
template <class T> OMNIMORPH_FN Mat3<T> least_rotation(const Vec3<T>& a, const Vec3<T>& b) {
    const Vec3<T> v = cross(a, b);
    const T k = T(1) / max(T(1) + dot(a, b), T(1e-6));
    return {{{T(1) - k * (v[1] * v[1] + v[2] * v[2]), k * v[0] * v[1] - v[2], k * v[0] * v[2] + v[1]},
             {k * v[0] * v[1] + v[2], T(1) - k * (v[0] * v[0] + v[2] * v[2]), k * v[1] * v[2] - v[0]},
             {k * v[0] * v[2] - v[1], k * v[1] * v[2] + v[0], T(1) - k * (v[0] * v[0] + v[1] * v[1])}}};
}

/// The attitude nearest to R in which the acceleration, in W, can be given.
template <class T>
OMNIMORPH_FN Mat3<T> attitude_for(const Mat3<T>& R, const Vec3<T>& acceleration, const PositionFirst<T>& settings) {
    const Vec3<T> f = settings.mass * Vec3<T>{{acceleration[0], acceleration[1], acceleration[2] + T(gravity)}};
    const Vec3<T> z{{R[0][2], R[1][2], R[2][2]}};
    const T size = max(sqrt(dot(f, f)), T(1e-9));
    const Vec3<T> towards = (T(1) / size) * f;
    const T sine = min(settings.lateral_force / size, T(1)), cosine = sqrt(max(T(1) - sine * sine, T(0)));
    const Vec3<T> aside = z - dot(z, towards) * towards;  // in the plane of z and f, at right angles to f
    const T length = sqrt(dot(aside, aside));
    const Mask<T> gives_way = dot(z, towards) < cosine;
    const Vec3<T> new_z = cosine * towards + (sine / max(length, T(1e-9))) * aside;
    const Mat3<T> turned = least_rotation(z, new_z) * R;
    Mat3<T> out;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) out[r][c] = select(gives_way, turned[r][c], R[r][c]);
    return out;
}

/// The attitude that was planned in the last control step.
template <class T> struct PositionFirstState {
    Mat3<T> planned{};
    bool started = false;

    static constexpr auto fields() {
        return field_list(field("planned", &PositionFirstState::planned),
                          field("started", &PositionFirstState::started));
    }
};

/// What is tracked instead of the desired motion: an attitude that can be held while the position is followed.
///
/// Its rate is that of the attitude for the reference's own acceleration, from one control step to the next: feedback,
/// which is noisy, turns the attitude but not its rate.
template <class T>
OMNIMORPH_FN Desired<T> position_first(const PositionFirst<T>& settings, const Motion<T>& estimate,
                                       const Desired<T>& desired, const TrackingGains<T>& gains,
                                       PositionFirstState<T>& state) {
    const Mat3<T> planned = attitude_for(desired.R, desired.a, settings);
    Desired<T> out = desired;
    out.R = attitude_for(desired.R, linear_acceleration(estimate, desired, gains), settings);
    if (state.started) out.w = (T(1) / settings.period) * vee_of_skew_part(transpose_times(state.planned, planned));
    out.dw = Vec3<T>::zero();
    state.planned = planned;
    state.started = true;
    return out;
}

}  // namespace omnimorph
