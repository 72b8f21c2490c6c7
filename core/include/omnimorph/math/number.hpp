// What a number is: double, float, a pack of them that one SIMD register holds (pack.hpp), or any type that has the
// functions below, such as one that carries a derivative. They are found by argument, in the namespace of the type.
//
// Everything above this file is written once for a number type T. Decisions that may differ from lane to
// lane are taken with `select` on a mask; a branch is taken only on `any` of a mask.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "placement.hpp"

namespace omnimorph {

// ---- what a type of numbers brings ---------------------------------------------------------------------

template <class T> using IfFloat = std::enable_if_t<std::is_floating_point_v<T>>;

OMNIMORPH_FN bool any(bool mask) {
    return mask;
}
OMNIMORPH_FN bool all(bool mask) {
    return mask;
}
template <class T, class = IfFloat<T>> OMNIMORPH_FN T select(bool mask, T yes, T no) {
    return mask ? yes : no;
}
OMNIMORPH_FN double sqrt(double x) {
    return std::sqrt(x);
}
OMNIMORPH_FN float sqrt(float x) {
    return std::sqrt(x);
}
OMNIMORPH_FN double nearbyint(double x) {
    return std::nearbyint(x);
}
OMNIMORPH_FN float nearbyint(float x) {
    return std::nearbyint(x);
}

/// The scalar that one lane holds, the truth of a comparison, and how many lanes there are.
template <class T> struct NumberTraits {
    using Scalar = T;
    using Mask = bool;
    static constexpr int lanes = 1;
    static constexpr bool is_double = sizeof(T) >= sizeof(double);  // whether it is good to 16 digits
};
template <class T> using Mask = typename NumberTraits<T>::Mask;
template <class T> using Scalar = typename NumberTraits<T>::Scalar;
template <class T> inline constexpr int lane_count = NumberTraits<T>::lanes;
template <class T> inline constexpr bool is_double = NumberTraits<T>::is_double;

/// The number of one lane, and another one in its place.
template <class T> OMNIMORPH_FN const T& lane(const T& x, int) {
    return x;
}
template <class T> OMNIMORPH_FN void set_lane(T& x, int, const T& value) {
    x = value;
}
OMNIMORPH_FN bool is_set(bool mask, int) {
    return mask;
}

/// The bits of each number as an unsigned integer of its size, and back.
template <int Bytes> struct IntegerOfSize;
template <> struct IntegerOfSize<4> {
    using Type = std::int32_t;
};
template <> struct IntegerOfSize<8> {
    using Type = std::int64_t;
};
template <class T> struct Bits {
    using Type = std::make_unsigned_t<typename IntegerOfSize<sizeof(T)>::Type>;
};
template <class T> OMNIMORPH_FN typename Bits<T>::Type bits_of(const T& x) {
    typename Bits<T>::Type bits;
    std::memcpy(&bits, &x, sizeof(T));
    return bits;
}
template <class T> OMNIMORPH_FN T from_bits(const typename Bits<T>::Type& bits) {
    T x;
    std::memcpy(&x, &bits, sizeof(T));
    return x;
}

// ---- functions of any number ---------------------------------------------------------------------------

template <class T> OMNIMORPH_FN T min(const T& a, const T& b) {
    return select(a < b, a, b);
}
template <class T> OMNIMORPH_FN T max(const T& a, const T& b) {
    return select(a > b, a, b);
}
/// x within the limits; what is not a number stays so.
template <class T> OMNIMORPH_FN T clamp(const T& x, const T& low, const T& high) {
    return select(x < low, low, select(x > high, high, x));
}
template <class T> OMNIMORPH_FN T abs(const T& x) {
    return from_bits<T>(bits_of(x) & ~bits_of(T(-0.0)));
}
/// |x| with the sign of `sign` (a zero sign counts as positive).
template <class T> OMNIMORPH_FN T with_sign(const T& x, const T& sign) {
    return select(sign < T(0), -abs(x), abs(x));
}
template <class T> OMNIMORPH_FN Mask<T> is_finite(const T& x) {
    return (x - x) == T(0);
}
/// The larger of two numbers, and not a number if one of them is none.
template <class T> OMNIMORPH_FN T max_or_nan(const T& a, const T& b) {
    return select((a >= b) | !(a == a), a, b);
}

/// sin x and cos x in every lane, for |x| up to about 1e5, to the last bit or two of a double.
///
/// Reduced to [-pi/4, pi/4] in three parts (W. J. Cody, W. Waite, "Software Manual for the Elementary Functions",
/// 1980), where Taylor's series are short. The same text for one lane and for many, so that a flight does not depend on
/// what flies beside it.
template <class T> OMNIMORPH_FN void sincos(const T& x, T& sine, T& cosine) {
    const T quadrant = nearbyint(x * T(0.63661977236758134308));
    T r = x - quadrant * T(1.57079632673412561417);
    r = r - quadrant * T(6.07710050630396597660e-11);
    r = r - quadrant * T(2.02226624879595063154e-21);
    const T r2 = r * r;

    // in pairs and pairs of pairs, so that no term waits for all others
    const T r4 = r2 * r2, r8 = r4 * r4;
    const T s_low = (T(1.0 / 120.0) + r2 * T(-1.0 / 5040.0)) + r4 * (T(1.0 / 362880.0) + r2 * T(-1.0 / 39916800.0));
    const T s_high = (T(1.0 / 6227020800.0) + r2 * T(-1.0 / 1307674368000.0)) + r4 * T(1.0 / 355687428096000.0);
    const T s = r + r * r2 * (T(-1.0 / 6.0) + r2 * (s_low + r8 * s_high));
    const T c_low = (T(-1.0 / 720.0) + r2 * T(1.0 / 40320.0)) + r4 * (T(-1.0 / 3628800.0) + r2 * T(1.0 / 479001600.0));
    const T c_high = (T(-1.0 / 87178291200.0) + r2 * T(1.0 / 20922789888000.0)) + r4 * T(-1.0 / 6402373705728000.0);
    const T c = (T(1) - T(0.5) * r2) + r4 * (T(1.0 / 24.0) + r2 * (c_low + r8 * c_high));

    // quadrant mod 4 in {0, 1, 2, 3}: odd quadrants swap sine and cosine, the upper two flip signs
    const T turn = quadrant - T(4) * nearbyint(quadrant * T(0.25) - T(0.375));
    const Mask<T> odd = (turn == T(1)) | (turn == T(3));
    const T swapped_sine = select(odd, c, s);
    const T swapped_cosine = select(odd, s, c);
    sine = select(turn >= T(2), -swapped_sine, swapped_sine);
    cosine = select((turn == T(1)) | (turn == T(2)), -swapped_cosine, swapped_cosine);
}

}  // namespace omnimorph
