// Many numbers in one SIMD register, computed together (vector extensions of GCC and clang).
#pragma once

#include "number.hpp"

namespace omnimorph {

/// Truth of one comparison in every lane; all bits set where it holds.
template <class S, int Lanes> struct PackMask {
    using Integer = typename IntegerOfSize<sizeof(S)>::Type;
    typedef Integer Register __attribute__((vector_size(Lanes * sizeof(S))));
    Register bits;

    friend OMNIMORPH_FN PackMask operator&(PackMask a, PackMask b) { return {a.bits & b.bits}; }
    friend OMNIMORPH_FN PackMask operator|(PackMask a, PackMask b) { return {a.bits | b.bits}; }
    friend OMNIMORPH_FN PackMask operator!(PackMask a) { return {~a.bits}; }
    friend OMNIMORPH_FN bool any(PackMask a) {
        Integer joined = 0;
        for (int lane = 0; lane < Lanes; ++lane) joined |= a.bits[lane];
        return joined != 0;
    }
    friend OMNIMORPH_FN bool all(PackMask a) { return !any(!a); }
    friend OMNIMORPH_FN bool is_set(const PackMask& mask, int lane) { return mask.bits[lane] != 0; }
};

/// `Lanes` numbers of type S.
template <class S, int Lanes> struct Pack {
    typedef S Register __attribute__((vector_size(Lanes * sizeof(S))));
    using Mask = PackMask<S, Lanes>;
    Register lanes;

    Pack() = default;
    OMNIMORPH_FN Pack(Register r) : lanes(r) {}
    template <class U, class = std::enable_if_t<std::is_arithmetic_v<U>>> OMNIMORPH_FN Pack(U x) {
        for (int lane = 0; lane < Lanes; ++lane) lanes[lane] = static_cast<S>(x);
    }

    OMNIMORPH_FN S operator[](int lane) const { return lanes[lane]; }
    OMNIMORPH_FN void set(int lane, S x) { lanes[lane] = x; }

    friend OMNIMORPH_FN Pack operator+(Pack a, Pack b) { return Pack(a.lanes + b.lanes); }
    friend OMNIMORPH_FN Pack operator-(Pack a, Pack b) { return Pack(a.lanes - b.lanes); }
    friend OMNIMORPH_FN Pack operator*(Pack a, Pack b) { return Pack(a.lanes * b.lanes); }
    friend OMNIMORPH_FN Pack operator/(Pack a, Pack b) { return Pack(a.lanes / b.lanes); }
    friend OMNIMORPH_FN Pack operator-(Pack a) { return Pack(-a.lanes); }
    OMNIMORPH_FN Pack& operator+=(Pack b) { return lanes += b.lanes, *this; }
    OMNIMORPH_FN Pack& operator-=(Pack b) { return lanes -= b.lanes, *this; }
    OMNIMORPH_FN Pack& operator*=(Pack b) { return lanes *= b.lanes, *this; }
    friend OMNIMORPH_FN Mask operator<(Pack a, Pack b) { return {a.lanes < b.lanes}; }
    friend OMNIMORPH_FN Mask operator>(Pack a, Pack b) { return {a.lanes > b.lanes}; }
    friend OMNIMORPH_FN Mask operator<=(Pack a, Pack b) { return {a.lanes <= b.lanes}; }
    friend OMNIMORPH_FN Mask operator>=(Pack a, Pack b) { return {a.lanes >= b.lanes}; }
    friend OMNIMORPH_FN Mask operator==(Pack a, Pack b) { return {a.lanes == b.lanes}; }
    friend OMNIMORPH_FN Pack select(Mask mask, Pack yes, Pack no) { return Pack(mask.bits ? yes.lanes : no.lanes); }
    friend OMNIMORPH_FN Pack sqrt(Pack a) {
        for (int lane = 0; lane < Lanes; ++lane) a.lanes[lane] = std::sqrt(a.lanes[lane]);
        return a;
    }
    friend OMNIMORPH_FN Pack nearbyint(Pack a) {
        for (int lane = 0; lane < Lanes; ++lane) a.lanes[lane] = std::nearbyint(a.lanes[lane]);
        return a;
    }
};

template <class S, int Lanes> struct NumberTraits<Pack<S, Lanes>> {
    using Scalar = S;
    using Mask = PackMask<S, Lanes>;
    static constexpr int lanes = Lanes;
    static constexpr bool is_double = NumberTraits<S>::is_double;
};
template <class S, int Lanes> OMNIMORPH_FN S lane(const Pack<S, Lanes>& x, int index) {
    return x[index];
}
template <class S, int Lanes> OMNIMORPH_FN void set_lane(Pack<S, Lanes>& x, int index, S value) {
    x.set(index, value);
}

template <class S, int Lanes> struct Bits<Pack<S, Lanes>> {
    typedef typename Bits<S>::Type Type __attribute__((vector_size(Lanes * sizeof(S))));
};

}  // namespace omnimorph
