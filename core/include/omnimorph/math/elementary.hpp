// Exponential, logarithm, arc tangent and arc cosine of any number, written once: the same text for one lane and for
// many, so that a flight does not depend on what flies beside it. Each is brought to a short interval, where a Taylor
// series is short (W. J. Cody, W. Waite, "Software Manual for the Elementary Functions", 1980), and is good to a few
// units in the last place.
#pragma once

#include "number.hpp"

namespace omnimorph {

namespace elementary {

/// How the numbers of a type are made of bits.
template <class S> struct Format;
template <> struct Format<double> {
    static constexpr int mantissa_bits = 52, exponent_bias = 1023;
    static constexpr double one_and_a_half = 0x1.8p52;    // beside it an integer is the lowest bits of a number
    static constexpr double least = -708, largest = 709;  // whose exponentials are normal numbers
    static constexpr double ln2_high = 6.93147180369123816490e-01,
                            ln2_low = 1.90821492927058770002e-10;  // the high part ends in zeros
};
template <> struct Format<float> {
    static constexpr int mantissa_bits = 23, exponent_bias = 127;
    static constexpr float one_and_a_half = 0x1.8p23f;
    static constexpr float least = -87, largest = 88;
    static constexpr float ln2_high = 0.693359375f, ln2_low = -2.12194440054690583e-4f;
};

/// 2^k, k an integer within the exponents of normal numbers.
template <class T> OMNIMORPH_FN T power_of_two(const T& k) {
    using F = Format<Scalar<T>>;
    return from_bits<T>(bits_of(k + T(F::one_and_a_half + F::exponent_bias)) << F::mantissa_bits);
}

/// The exponent of a positive normal number: the integer e with x = m 2^e, 1 <= m < 2.
template <class T> OMNIMORPH_FN T exponent_of(const T& x) {
    using F = Format<Scalar<T>>;
    const T wanted = T(F::one_and_a_half);
    return from_bits<T>(bits_of(wanted) | (bits_of(x) >> F::mantissa_bits)) - wanted - T(F::exponent_bias);
}

/// sum of coefficients[k] x^k, from the highest power down.
template <class T, int K> OMNIMORPH_FN T polynomial(const T& x, const double (&coefficients)[K]) {
    T sum = T(coefficients[K - 1]);
    for (int k = K - 2; k >= 0; --k) sum = sum * x + T(coefficients[k]);
    return sum;
}

}  // namespace elementary

/// e^x; 0 below the normal numbers, the largest exponential above them.
template <class T> OMNIMORPH_FN T exp(const T& x) {
    using F = elementary::Format<Scalar<T>>;
    // e^r, |r| <= ln 2 / 2: the powers over their factorials
    constexpr double series[] = {
        1.0,        1.0,         1.0 / 2,      1.0 / 6,       1.0 / 24,       1.0 / 120,       1.0 / 720,
        1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800.0};
    const T within = clamp(x, T(F::least), T(F::largest));
    const T k = nearbyint(within * T(1.44269504088896340736));
    const T r = (within - k * T(F::ln2_high)) - k * T(F::ln2_low);
    const T value = elementary::polynomial(r, series) * elementary::power_of_two(k);
    return select(x < T(F::least), T(0), value);
}

/// The natural logarithm of a positive normal number.
template <class T> OMNIMORPH_FN T log(const T& x) {
    using F = elementary::Format<Scalar<T>>;
    // ln m = 2 (s + s³/3 + s⁵/5 + …), s = (m - 1) / (m + 1), √½ <= m < √2
    constexpr double series[] = {2.0 / 3,  2.0 / 5,  2.0 / 7,  2.0 / 9,  2.0 / 11,
                                 2.0 / 13, 2.0 / 15, 2.0 / 17, 2.0 / 19, 2.0 / 21};
    const T e = elementary::exponent_of(x * T(0.70710678118654752440)) + T(1);
    const T m = x * elementary::power_of_two(-e);
    const T s = (m - T(1)) / (m + T(1)), s2 = s * s;
    const T beyond = s * (s2 * elementary::polynomial(s2, series));
    return e * T(F::ln2_high) + (e * T(F::ln2_low) + beyond + T(2) * s);
}

/// The angle of the point (x, y), from -pi to pi; 0 at the origin.
template <class T> OMNIMORPH_FN T atan2(const T& y, const T& x) {
    constexpr double pi = 3.14159265358979323846, tangent_8 = 0.41421356237309504880;  // of pi / 8
    // atan t = t - t³/3 + t⁵/5 …, |t| <= tan(pi / 16)
    constexpr double series[] = {-1.0 / 3,  1.0 / 5,  -1.0 / 7,  1.0 / 9,  -1.0 / 11, 1.0 / 13,
                                 -1.0 / 15, 1.0 / 17, -1.0 / 19, 1.0 / 21, -1.0 / 23};
    const T width = abs(x), height = abs(y);
    const Mask<T> steep = height > width;
    const T larger = select(steep, height, width), smaller = select(steep, width, height);
    // from the nearest of 0, pi/8 and pi/4: the tangent of the difference of two angles
    const Mask<T> near_8 = smaller > T(0.19891236737965800691) * larger,
                  near_4 = smaller > T(0.66817863791929891999) * larger;
    const T tangent = select(near_4, T(1), select(near_8, T(tangent_8), T(0)));
    const T base = select(near_4, T(pi / 4), select(near_8, T(pi / 8), T(0)));
    const T below = larger + tangent * smaller;
    const T t = (smaller - tangent * larger) / select(below == T(0), T(1), below), t2 = t * t;
    T angle = base + (t + t * (t2 * elementary::polynomial(t2, series)));
    angle = select(steep, T(pi / 2) - angle, angle);
    angle = select(x < T(0), T(pi) - angle, angle);
    return select(y < T(0), -angle, angle);
}

/// The angle from 0 to pi whose cosine is x, |x| <= 1; what is beyond counts as ±1.
template <class T> OMNIMORPH_FN T acos(const T& x) {
    const T cosine = clamp(x, T(-1), T(1));
    return atan2(sqrt((T(1) - cosine) * (T(1) + cosine)), cosine);
}

}  // namespace omnimorph
