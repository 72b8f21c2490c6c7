// The wrench of all rotors, w_B = A(alpha) f, its derivative in the tilt, and the rotors' axes.
#pragma once

#include "vehicle.hpp"

namespace omnimorph {

/// cos and sin of every servo angle.
template <class T> struct TiltTrigonometry {
    PerServo<T> cosine, sine;
};
template <class T> OMNIMORPH_FN TiltTrigonometry<T> trigonometry_of(const PerServo<T>& tilt, int n_servos) {
    TiltTrigonometry<T> out;
    out.cosine[0] = T(1);
    out.sine[0] = T(0);
    for (int j = 0; j < n_servos; ++j) sincos(tilt[j], out.sine[j], out.cosine[j]);
    return out;
}

/// z_i(alpha) = z0 + zC cos alpha + zS sin alpha: Rodrigues' rotation about the hinge, exact (docs/notation.md).
template <class T, int N, class U>
OMNIMORPH_FN Vec3<U> rotor_axis(const Vehicle<T, N>& vehicle, int i, const TiltTrigonometry<U>& trig) {
    const U c = trig.cosine[vehicle.servo[i]], s = trig.sine[vehicle.servo[i]];
    Vec3<U> z;
    for (int r = 0; r < 3; ++r)
        z[r] = U(vehicle.axis[i][r]) + U(vehicle.axis_cosine[i][r]) * c + U(vehicle.axis_sine[i][r]) * s;
    return z;
}

/// A matrix of one 6-vector (force, then torque, in B) for each rotor.
template <class T, int N> struct WrenchMatrix {
    PerRotor<Vec6<T>, N> column;
};

/// A(alpha) = A0 + AC cos alpha + AS sin alpha, column by column, from what each rotor gives per unit of its input:
///
///     column_i = [ a_i z_i ; a_i p_i x z_i - k_i d_i z_i ]
///
/// With a = 1, d = kappa the input is thrust in N and this is the paper's A (eq. 10); with a = c_f, d = c_tau it is the
/// signed squared speed.
template <class T, int N> struct WrenchMap {
    Count<N> n;
    int n_servos;
    PerRotor<int, N> servo;
    PerRotor<Vec6<T>, N> constant, cosine, sine;

    OMNIMORPH_FN WrenchMap(const Vehicle<T, N>& vehicle, const PerRotor<T, N>& force_per_input,
                           const PerRotor<T, N>& drag_per_input)
        : n(vehicle.n_rotors), n_servos(vehicle.n_servos), servo(vehicle.servo) {
        for (int i = 0; i < n; ++i) {
            const auto column = [&](const Vec3<T>& z) {
                const Vec3<T> force = force_per_input[i] * z;
                const Vec3<T> torque = cross(vehicle.position[i], force) - (vehicle.spin[i] * drag_per_input[i]) * z;
                return Vec6<T>{{force[0], force[1], force[2], torque[0], torque[1], torque[2]}};
            };
            constant[i] = column(vehicle.axis[i]);
            cosine[i] = column(vehicle.axis_cosine[i]);
            sine[i] = column(vehicle.axis_sine[i]);
        }
    }

    /// Column i of A(alpha); U is T, or a pack of tilts for one vehicle.
    template <class U> OMNIMORPH_FN Vec6<U> column_at(int i, const TiltTrigonometry<U>& trig) const {
        const U c = trig.cosine[servo[i]], s = trig.sine[servo[i]];
        Vec6<U> column;
        for (int r = 0; r < 6; ++r) column[r] = U(constant[i][r]) + U(cosine[i][r]) * c + U(sine[i][r]) * s;
        return column;
    }

    /// A(alpha)
    template <class U> OMNIMORPH_FN WrenchMatrix<U, N> at(const TiltTrigonometry<U>& trig) const {
        WrenchMatrix<U, N> A;
        for (int i = 0; i < n; ++i) A.column[i] = column_at<U>(i, trig);
        return A;
    }

    /// Column i of dA/dalpha, the derivative in the angle of the rotor's own servo: AS cos alpha - AC sin alpha.
    OMNIMORPH_FN Vec6<T> tilt_derivative(int i, const TiltTrigonometry<T>& trig) const {
        return trig.cosine[servo[i]] * sine[i] - trig.sine[servo[i]] * cosine[i];
    }
};

/// The map of thrusts, each in a unit of its own, in N; with units of 1 N it is A(alpha) of the paper.
template <class T, int N>
OMNIMORPH_FN WrenchMap<T, N> thrust_wrench_map(const Vehicle<T, N>& vehicle, const PerRotor<T, N>& unit) {
    PerRotor<T, N> drag{};
    for (int i = 0; i < vehicle.n_rotors; ++i) drag[i] = vehicle.kappa(i) * unit[i];
    return WrenchMap<T, N>(vehicle, unit, drag);
}

/// A u
template <class T, int N> OMNIMORPH_FN Vec6<T> wrench(const WrenchMatrix<T, N>& A, const PerRotor<T, N>& u, int n) {
    Vec6<T> w = Vec6<T>::zero();
    for (int i = 0; i < n; ++i)
        for (int r = 0; r < 6; ++r) w[r] += A.column[i][r] * u[i];
    return w;
}

template <class T> OMNIMORPH_FN Vec3<T> force_of(const Vec6<T>& w) {
    return {{w[0], w[1], w[2]}};
}
template <class T> OMNIMORPH_FN Vec3<T> torque_of(const Vec6<T>& w) {
    return {{w[3], w[4], w[5]}};
}
template <class T> OMNIMORPH_FN Vec6<T> joined(const Vec3<T>& force, const Vec3<T>& torque) {
    return {{force[0], force[1], force[2], torque[0], torque[1], torque[2]}};
}

}  // namespace omnimorph
