// What a number is: double, float, or a pack of them that one SIMD register holds.
//
// Everything above this file is written once for a number type T. Decisions that may differ from lane to
// lane are taken with `select` on a mask; a branch is taken only on `any` of a mask.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace omnimorph {

// ---- one lane ------------------------------------------------------------------------------------------

inline bool any(bool mask) { return mask; }
inline bool both(bool a, bool b) { return a && b; }
inline bool either(bool a, bool b) { return a || b; }
inline bool opposite(bool a) { return !a; }
template <class T, class = std::enable_if_t<std::is_floating_point_v<T>>>
inline T select(bool mask, T yes, T no) {
    return mask ? yes : no;
}
inline double square_root(double x) { return std::sqrt(x); }
inline float square_root(float x) { return std::sqrt(x); }
inline double round_to_integer(double x) { return std::nearbyint(x); }
inline float round_to_integer(float x) { return std::nearbyint(x); }

// ---- many lanes ----------------------------------------------------------------------------------------

template <int Bytes> struct IntegerOfSize;
template <> struct IntegerOfSize<4> { using Type = std::int32_t; };
template <> struct IntegerOfSize<8> { using Type = std::int64_t; };

/// Truth of one comparison in every lane; all bits set where it holds.
template <class S, int Lanes> struct PackMask {
    using Integer = typename IntegerOfSize<sizeof(S)>::Type;
    typedef Integer Register __attribute__((vector_size(Lanes * sizeof(S))));
    Register bits;

    friend PackMask both(PackMask a, PackMask b) { return {a.bits & b.bits}; }
    friend PackMask either(PackMask a, PackMask b) { return {a.bits | b.bits}; }
    friend PackMask opposite(PackMask a) { return {~a.bits}; }
    friend bool any(PackMask a) {
        Integer joined = 0;
        for (int lane = 0; lane < Lanes; ++lane) joined |= a.bits[lane];
        return joined != 0;
    }
};

/// `Lanes` numbers of type S that are computed together (GCC and clang vector extensions).
template <class S, int Lanes> struct Pack {
    typedef S Register __attribute__((vector_size(Lanes * sizeof(S))));
    using Mask = PackMask<S, Lanes>;
    Register lanes;

    Pack() = default;
    Pack(Register r) : lanes(r) {}
    template <class U, class = std::enable_if_t<std::is_arithmetic_v<U>>>
    Pack(U x) {
        for (int lane = 0; lane < Lanes; ++lane) lanes[lane] = static_cast<S>(x);
    }

    S operator[](int lane) const { return lanes[lane]; }
    void set(int lane, S x) { lanes[lane] = x; }

    friend Pack operator+(Pack a, Pack b) { return Pack(a.lanes + b.lanes); }
    friend Pack operator-(Pack a, Pack b) { return Pack(a.lanes - b.lanes); }
    friend Pack operator*(Pack a, Pack b) { return Pack(a.lanes * b.lanes); }
    friend Pack operator/(Pack a, Pack b) { return Pack(a.lanes / b.lanes); }
    friend Pack operator-(Pack a) { return Pack(-a.lanes); }
    Pack& operator+=(Pack b) { return lanes += b.lanes, *this; }
    Pack& operator-=(Pack b) { return lanes -= b.lanes, *this; }
    Pack& operator*=(Pack b) { return lanes *= b.lanes, *this; }
    friend Mask operator<(Pack a, Pack b) { return {a.lanes < b.lanes}; }
    friend Mask operator>(Pack a, Pack b) { return {a.lanes > b.lanes}; }
    friend Mask operator<=(Pack a, Pack b) { return {a.lanes <= b.lanes}; }
    friend Mask operator>=(Pack a, Pack b) { return {a.lanes >= b.lanes}; }
    friend Mask operator==(Pack a, Pack b) { return {a.lanes == b.lanes}; }
    friend Pack select(Mask mask, Pack yes, Pack no) { return Pack(mask.bits ? yes.lanes : no.lanes); }
    friend Pack square_root(Pack a) {
        for (int lane = 0; lane < Lanes; ++lane) a.lanes[lane] = std::sqrt(a.lanes[lane]);
        return a;
    }
    friend Pack round_to_integer(Pack a) {
        for (int lane = 0; lane < Lanes; ++lane) a.lanes[lane] = std::nearbyint(a.lanes[lane]);
        return a;
    }
};

// ---- traits --------------------------------------------------------------------------------------------

template <class T> struct NumberTraits {
    using Scalar = T;
    using Mask = bool;
    static constexpr int lanes = 1;
};
template <class S, int Lanes> struct NumberTraits<Pack<S, Lanes>> {
    using Scalar = S;
    using Mask = PackMask<S, Lanes>;
    static constexpr int lanes = Lanes;
};
template <class T> using Mask = typename NumberTraits<T>::Mask;
template <class T> using Scalar = typename NumberTraits<T>::Scalar;
template <class T> inline constexpr int lane_count = NumberTraits<T>::lanes;

template <class T> inline Scalar<T> lane(const T& x, [[maybe_unused]] int index) {
    if constexpr (lane_count<T> == 1) {
        return x;
    } else {
        return x[index];
    }
}
template <class T> inline void set_lane(T& x, [[maybe_unused]] int index, Scalar<T> value) {
    if constexpr (lane_count<T> == 1) {
        x = value;
    } else {
        x.set(index, value);
    }
}

/// The bits of each number as an unsigned integer of its size, and back.
template <class T> struct Bits { using Type = std::make_unsigned_t<typename IntegerOfSize<sizeof(T)>::Type>; };
template <class S, int Lanes> struct Bits<Pack<S, Lanes>> {
    typedef typename Bits<S>::Type Type __attribute__((vector_size(Lanes * sizeof(S))));
};
template <class T> inline typename Bits<T>::Type bits_of(const T& x) {
    typename Bits<T>::Type bits;
    std::memcpy(&bits, &x, sizeof(T));
    return bits;
}
template <class T> inline T from_bits(const typename Bits<T>::Type& bits) {
    T x;
    std::memcpy(&x, &bits, sizeof(T));
    return x;
}

inline bool is_set(bool mask, [[maybe_unused]] int index) { return mask; }
template <class S, int Lanes> inline bool is_set(const PackMask<S, Lanes>& mask, int index) { return mask.bits[index] != 0; }

// ---- functions of any number ---------------------------------------------------------------------------

template <class T> inline T minimum(const T& a, const T& b) { return select(a < b, a, b); }
template <class T> inline T maximum(const T& a, const T& b) { return select(a > b, a, b); }
/// x within the limits; what is not a number stays so.
template <class T> inline T clamp(const T& x, const T& low, const T& high) {
    return select(x < low, low, select(x > high, high, x));
}
template <class T> inline T magnitude(const T& x) { return from_bits<T>(bits_of(x) & ~bits_of(T(-0.0))); }
/// |x| with the sign of `sign` (a zero sign counts as positive).
template <class T> inline T with_sign(const T& x, const T& sign) {
    return select(sign < T(0), -magnitude(x), magnitude(x));
}
template <class T> inline Mask<T> is_finite(const T& x) { return (x - x) == T(0); }
/// The larger of two numbers, and not a number if one of them is none.
template <class T> inline T larger_or_nan(const T& a, const T& b) { return select(either(a >= b, opposite(a == a)), a, b); }

/// sin x and cos x in every lane, for |x| up to about 1e5, to the last bit or two of a double.
///
/// Reduced to [-pi/4, pi/4] in three parts (W. J. Cody, W. Waite, "Software Manual for the Elementary Functions", 1980),
/// where Taylor's series are short. The same text for one lane and for many, so that a flight does not depend on what
/// flies beside it.
template <class T> inline void sincos(const T& x, T& sine, T& cosine) {
    const T quadrant = round_to_integer(x * T(0.63661977236758134308));
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
    const T turn = quadrant - T(4) * round_to_integer(quadrant * T(0.25) - T(0.375));
    const Mask<T> odd = either(turn == T(1), turn == T(3));
    const T swapped_sine = select(odd, c, s);
    const T swapped_cosine = select(odd, s, c);
    sine = select(turn >= T(2), -swapped_sine, swapped_sine);
    cosine = select(either(turn == T(1), turn == T(2)), -swapped_cosine, swapped_cosine);
}

}  // namespace omnimorph
