// What a vehicle is: a rigid body, rotors and the servos that tilt them. SI units, body frame B at the centre of mass.
// Lags, dead bands and the like are no part of it: they are effects that the plant may have (effects/).
#pragma once

#include "../math/matrix.hpp"

namespace omnimorph {

inline constexpr double gravity = 9.81;       // m/s²
inline constexpr int most_rotors = 18;
inline constexpr int most_servos = 18;

/// The number of rotors: a constant of the type (N > 0), or counted at run time (N = 0).
template <int N> struct Count {
    explicit Count(int = N) {}
    constexpr operator int() const { return N; }
};
template <> struct Count<0> {
    int value = 0;
    explicit Count(int n = 0) : value(n) {}
    operator int() const { return value; }
};

/// One number for each rotor.
template <class T, int N> struct PerRotor {
    T a[N > 0 ? N : most_rotors];
    T& operator[](int i) { return a[i]; }
    const T& operator[](int i) const { return a[i]; }
};
/// One number for each servo.
template <class T> struct PerServo {
    T a[most_servos];
    T& operator[](int j) { return a[j]; }
    const T& operator[](int j) const { return a[j]; }
};

// The same numbers in another type, for another way of counting rotors.
template <class T, int N, class S, int M> OMNIMORPH_FN PerRotor<T, N> cast(const PerRotor<S, M>& x, int n) {
    PerRotor<T, N> y{};
    for (int i = 0; i < n; ++i) y[i] = T(x[i]);
    return y;
}
template <class T, int N, class S, int M> OMNIMORPH_FN PerRotor<Vec3<T>, N> cast(const PerRotor<Vec3<S>, M>& x, int n) {
    PerRotor<Vec3<T>, N> y{};
    for (int i = 0; i < n; ++i) y[i] = cast<T>(x[i]);
    return y;
}
template <class T, class S> OMNIMORPH_FN PerServo<T> cast(const PerServo<S>& x, int m) {
    PerServo<T> y{};
    for (int j = 0; j < m; ++j) y[j] = T(x[j]);
    return y;
}

template <class T, int N> struct Vehicle {
    Count<N> n_rotors;
    int n_servos = 0;
    T mass;
    Mat3<T> inertia, inertia_inverse;

    PerRotor<Vec3<T>, N> position;                        // p_i, m
    PerRotor<Vec3<T>, N> axis, axis_cosine, axis_sine;    // z_i(alpha) = z0 + zC cos alpha + zS sin alpha
    PerRotor<int, N> servo;                               // its servo; 0 for a rotor that does not tilt (zC = zS = 0)
    PerRotor<T, N> spin;                                  // k_i, +1 counter-clockwise
    PerRotor<T, N> thrust_coefficient;                    // c_f, N s²/rad²
    PerRotor<T, N> drag_coefficient;                      // c_tau, N m s²/rad²
    PerRotor<T, N> speed_min, speed_max;                  // rad/s, negative where it can turn the other way
    PerRotor<T, N> spin_inertia;                          // kg m²

    PerServo<T> angle_min, angle_max, rate_max;  // rad, rad/s

    explicit Vehicle(int n = N) : n_rotors(n) {}

    /// The same vehicle for another number type or rotor count.
    template <class S, int M> explicit Vehicle(const Vehicle<S, M>& other) : n_rotors(other.n_rotors), n_servos(other.n_servos) {
        const int n = n_rotors, m = n_servos;
        mass = T(other.mass);
        inertia = cast<T>(other.inertia);
        inertia_inverse = cast<T>(other.inertia_inverse);
        position = cast<T, N>(other.position, n);
        axis = cast<T, N>(other.axis, n);
        axis_cosine = cast<T, N>(other.axis_cosine, n);
        axis_sine = cast<T, N>(other.axis_sine, n);
        servo = cast<int, N>(other.servo, n);
        spin = cast<T, N>(other.spin, n);
        thrust_coefficient = cast<T, N>(other.thrust_coefficient, n);
        drag_coefficient = cast<T, N>(other.drag_coefficient, n);
        speed_min = cast<T, N>(other.speed_min, n);
        speed_max = cast<T, N>(other.speed_max, n);
        spin_inertia = cast<T, N>(other.spin_inertia, n);
        angle_min = cast<T>(other.angle_min, m);
        angle_max = cast<T>(other.angle_max, m);
        rate_max = cast<T>(other.rate_max, m);
    }

    T thrust_min(int i) const { return thrust_coefficient[i] * speed_min[i] * abs(speed_min[i]); }
    T thrust_max(int i) const { return thrust_coefficient[i] * speed_max[i] * abs(speed_max[i]); }
    T kappa(int i) const { return drag_coefficient[i] / thrust_coefficient[i]; }  // m
};

}  // namespace omnimorph
