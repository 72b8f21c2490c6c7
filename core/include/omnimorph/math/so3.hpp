// The rotation group: vee, exponential map, the differential of its inverse, and projection back onto it.
#pragma once

#include "matrix.hpp"

namespace omnimorph {

/// v with [v]x = (M - Mᵀ) / 2: the vector of the skew part of M.
template <class T> OMNIMORPH_FN Vec3<T> vee_of_skew_part(const Mat3<T>& M) {
    return {{T(0.5) * (M[2][1] - M[1][2]), T(0.5) * (M[0][2] - M[2][0]), T(0.5) * (M[1][0] - M[0][1])}};
}

/// exp([phi]x) = I + A [phi]x + B [phi]x², A = sin t / t, B = (1 - cos t) / t², t = |phi| (Rodrigues).
///
/// Below 0.25 rad the series of A and B are exact to the last bit and free of cancellation; one physics step of a
/// flight stays there.
template <class T> OMNIMORPH_FN Mat3<T> exp_so3(const Vec3<T>& phi) {
    const T t2 = dot(phi, phi);
    const T t4 = t2 * t2, t8 = t4 * t4;  // the series in pairs, so that no term waits for all others
    T A = (T(1) - T(1.0 / 6.0) * t2) + t4 * (T(1.0 / 120.0) - T(1.0 / 5040.0) * t2) +
          t8 * ((T(1.0 / 362880.0) - T(1.0 / 39916800.0) * t2) + t4 * T(1.0 / 6227020800.0));
    T B = (T(0.5) - T(1.0 / 24.0) * t2) + t4 * (T(1.0 / 720.0) - T(1.0 / 40320.0) * t2) +
          t8 * ((T(1.0 / 3628800.0) - T(1.0 / 479001600.0) * t2) + t4 * T(1.0 / 87178291200.0));
    const Mask<T> large = t2 > T(0.0625);
    if (any(large)) {
        const T t = sqrt(max(t2, T(0.0625)));
        T sine, cosine;
        sincos(t, sine, cosine);
        A = select(large, sine / t, A);
        B = select(large, (T(1) - cosine) / (t * t), B);
    }
    const T x = phi[0], y = phi[1], z = phi[2];
    return {{{T(1) - B * (y * y + z * z), B * x * y - A * z, B * x * z + A * y},
             {B * x * y + A * z, T(1) - B * (x * x + z * z), B * y * z - A * x},
             {B * x * z - A * y, B * y * z + A * x, T(1) - B * (x * x + y * y)}}};
}

/// Rate of phi when R = R0 exp([phi]x) turns with body rate w: w + phi x w / 2 + phi x (phi x w) / 12 + O(phi⁴).
template <class T> OMNIMORPH_FN Vec3<T> exp_so3_rate(const Vec3<T>& phi, const Vec3<T>& w) {
    const Vec3<T> first = cross(phi, w);
    return w + T(0.5) * first + T(1.0 / 12.0) * cross(phi, first);
}

/// One Newton step to the nearest rotation, R (3 I - RᵀR) / 2: removes what rounding has added over many steps.
template <class T> OMNIMORPH_FN Mat3<T> projected(const Mat3<T>& R) {
    Mat3<T> G = transpose_times(R, R);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) G[i][j] = T(i == j ? 1.5 : 0.0) - T(0.5) * G[i][j];
    return R * G;
}

}  // namespace omnimorph
