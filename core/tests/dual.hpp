// A dual number, a value and its derivative in one variable: what the headers need of a type of numbers that is not
// theirs. Its functions are found by argument; everything else (min, clamp, with_sign …) comes from theirs.
#pragma once

#include <type_traits>

#include "omnimorph/math/elementary.hpp"

namespace dual {

struct Dual {
    double value = 0, derivative = 0;

    Dual() = default;
    Dual(double v, double d) : value(v), derivative(d) {}
    template <class U, class = std::enable_if_t<std::is_arithmetic_v<U>>> Dual(U x) : value(static_cast<double>(x)) {}
    template <class U, class = std::enable_if_t<std::is_arithmetic_v<U>>> explicit operator U() const {
        return static_cast<U>(value);
    }

    friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.derivative + b.derivative}; }
    friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.derivative - b.derivative}; }
    friend Dual operator-(const Dual& a) { return {-a.value, -a.derivative}; }
    friend Dual operator*(const Dual& a, const Dual& b) {
        return {a.value * b.value, a.derivative * b.value + a.value * b.derivative};
    }
    friend Dual operator/(const Dual& a, const Dual& b) {
        const double quotient = a.value / b.value;
        return {quotient, (a.derivative - quotient * b.derivative) / b.value};
    }
    Dual& operator+=(const Dual& b) { return *this = *this + b; }
    Dual& operator-=(const Dual& b) { return *this = *this - b; }
    Dual& operator*=(const Dual& b) { return *this = *this * b; }

    friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
    friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
    friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
    friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
    friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
};

inline Dual select(bool mask, const Dual& yes, const Dual& no) {
    return mask ? yes : no;
}
inline Dual abs(const Dual& x) {
    return {omnimorph::abs(x.value), x.value < 0 ? -x.derivative : x.derivative};
}
inline Dual nearbyint(const Dual& x) {
    return {omnimorph::nearbyint(x.value), 0};
}
/// The derivative at 0, where there is none, counts as 0.
inline Dual sqrt(const Dual& x) {
    const double root = omnimorph::sqrt(x.value);
    return {root, root > 0 ? x.derivative / (2 * root) : 0};
}
inline Dual exp(const Dual& x) {
    const double power = omnimorph::exp(x.value);
    return {power, power * x.derivative};
}
inline Dual log(const Dual& x) {
    return {omnimorph::log(x.value), x.derivative / x.value};
}
inline Dual atan2(const Dual& y, const Dual& x) {
    const double square = x.value * x.value + y.value * y.value;
    return {omnimorph::atan2(y.value, x.value), (x.value * y.derivative - y.value * x.derivative) / square};
}
inline Dual acos(const Dual& x) {
    return {omnimorph::acos(x.value), -x.derivative / omnimorph::sqrt((1 - x.value) * (1 + x.value))};
}
inline void sincos(const Dual& x, Dual& sine, Dual& cosine) {
    omnimorph::sincos(x.value, sine.value, cosine.value);
    sine.derivative = cosine.value * x.derivative;
    cosine.derivative = -sine.value * x.derivative;
}

}  // namespace dual
