// What a vehicle is: a rigid body, rotors and the servos that tilt them. SI units, body frame B at the centre of mass.
// Lags, dead bands and the like are no part of it: they are effects that the plant may have (plant/).
#pragma once

#include "../math/fields.hpp"
#include "../math/matrix.hpp"

namespace omnimorph {

inline constexpr double gravity = 9.81;  // m/s²
inline constexpr int most_rotors = 18;
inline constexpr int most_servos = 18;

/// The number of rotors: a constant of the type (N > 0), or counted at run time (N = 0).
template <int N> struct Count {
    Count() = default;
    OMNIMORPH_FN explicit Count(int) {}
    OMNIMORPH_FN constexpr operator int() const { return N; }
};
template <> struct Count<0> {
    int value = 0;
    Count() = default;
    OMNIMORPH_FN explicit Count(int n) : value(n) {}
    OMNIMORPH_FN operator int() const { return value; }
};

/// One number for each rotor.
template <class T, int N> struct PerRotor {
    T a[N > 0 ? N : most_rotors];
    OMNIMORPH_FN T& operator[](int i) { return a[i]; }
    OMNIMORPH_FN const T& operator[](int i) const { return a[i]; }
};
/// One number for each servo.
template <class T> struct PerServo {
    T a[most_servos];
    OMNIMORPH_FN T& operator[](int j) { return a[j]; }
    OMNIMORPH_FN const T& operator[](int j) const { return a[j]; }
};

template <class T, int N> struct Vehicle {
    Count<N> n_rotors;
    int n_servos = 0;
    T mass;
    Mat3<T> inertia, inertia_inverse;

    PerRotor<Vec3<T>, N> position;                      // p_i, m
    PerRotor<Vec3<T>, N> axis, axis_cosine, axis_sine;  // z_i(alpha) = z0 + zC cos alpha + zS sin alpha
    PerRotor<int, N> servo;                             // its servo; 0 for a rotor that does not tilt (zC = zS = 0)
    PerRotor<T, N> spin;                                // k_i, +1 counter-clockwise
    PerRotor<T, N> thrust_coefficient;                  // c_f, N s²/rad²
    PerRotor<T, N> drag_coefficient;                    // c_tau, N m s²/rad²
    PerRotor<T, N> speed_min, speed_max;                // rad/s, negative where it can turn the other way
    PerRotor<T, N> spin_inertia;                        // kg m²

    PerServo<T> angle_min, angle_max, rate_max;  // rad, rad/s

    static constexpr auto fields() {
        using V = Vehicle;
        return field_list(
            derived("n_rotors", &V::n_rotors), derived("n_servos", &V::n_servos), field("mass", &V::mass),
            field("inertia", &V::inertia), derived("inertia_inverse", &V::inertia_inverse),
            field("position", &V::position), field("axis", &V::axis), field("axis_cosine", &V::axis_cosine),
            field("axis_sine", &V::axis_sine), field("servo", &V::servo), field("spin", &V::spin),
            field("thrust_coefficient", &V::thrust_coefficient), field("drag_coefficient", &V::drag_coefficient),
            field("speed_min", &V::speed_min), field("speed_max", &V::speed_max),
            field("spin_inertia", &V::spin_inertia), field("angle_min", &V::angle_min),
            field("angle_max", &V::angle_max), field("rate_max", &V::rate_max));
    }

    OMNIMORPH_FN T thrust_min(int i) const { return thrust_coefficient[i] * speed_min[i] * abs(speed_min[i]); }
    OMNIMORPH_FN T thrust_max(int i) const { return thrust_coefficient[i] * speed_max[i] * abs(speed_max[i]); }
    OMNIMORPH_FN T kappa(int i) const { return drag_coefficient[i] / thrust_coefficient[i]; }  // m
};

/// Set what follows from the other fields.
template <class T, int N> OMNIMORPH_FN void derive(Vehicle<T, N>& vehicle) {
    vehicle.inertia_inverse = inverse(vehicle.inertia);
}

}  // namespace omnimorph
