// Exponential, logarithm, arc tangent and arc cosine against the long double functions of the C library, over the
// ranges in which a flight needs them and at their edges, and in the lanes of packs against one lane. Exits 0 if no
// value is further off than four units in the last place, and none differs in a lane.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

#include "omnimorph/math/elementary.hpp"
#include "omnimorph/math/pack.hpp"

using namespace omnimorph;

namespace {

constexpr int rounds = 200000;
constexpr double allowed = 4;  // units in the last place

/// How many units in the last place of S a value is off.
template <class S> double units_off(S value, long double truth) {
    const S rounded = std::fabs(S(truth));
    const long double unit =
        std::nextafter(rounded, std::numeric_limits<S>::infinity()) - static_cast<long double>(rounded);
    return double(std::fabs(value - truth) / unit);
}

template <class S> struct Largest {
    double exponential = 0, logarithm = 0, tangent = 0, cosine = 0;
    int differ_in_lanes = 0;
};

/// One function of packs beside the same of each lane.
template <class S, int Lanes, class Function>
int lanes_that_differ(const Pack<S, Lanes>& x, const Pack<S, Lanes>& y, const Function& f) {
    const Pack<S, Lanes> together = f(x, y);
    int count = 0;
    for (int l = 0; l < Lanes; ++l) {
        const S one = f(x[l], y[l]), many = together[l];
        count += std::memcmp(&one, &many, sizeof(S)) != 0;
    }
    return count;
}

template <class S, int Lanes> Largest<S> largest_errors() {
    std::mt19937_64 random(5);
    const auto within = [&](double low, double high) { return S(low + (high - low) * (random() >> 11) * 0x1p-53); };
    const double most = sizeof(S) == sizeof(double) ? 700 : 85;
    Largest<S> out;
    for (int k = 0; k < rounds; ++k) {
        const S x = within(-most, most), positive = k % 2 ? std::exp(x) : within(0.6, 1.6), u = within(-1, 1);
        const S height = within(-1, 1) * std::exp(within(-10, 10)), width = within(-1, 1) * std::exp(within(-10, 10));
        const S cosine = k % 2 ? u : std::copysign(1 - std::exp(within(-30, 0)), u);  // also close to ±1
        out.exponential =
            std::max(out.exponential, units_off(omnimorph::exp(x), std::exp(static_cast<long double>(x))));
        if (positive != 1)
            out.logarithm = std::max(out.logarithm,
                                     units_off(omnimorph::log(positive), std::log(static_cast<long double>(positive))));
        out.tangent = std::max(
            out.tangent, units_off(omnimorph::atan2(height, width),
                                   std::atan2(static_cast<long double>(height), static_cast<long double>(width))));
        if (std::fabs(cosine) < 1)
            out.cosine =
                std::max(out.cosine, units_off(omnimorph::acos(cosine), std::acos(static_cast<long double>(cosine))));
        Pack<S, Lanes> a, b;
        for (int l = 0; l < Lanes; ++l) a.set(l, within(-1, 1)), b.set(l, within(-1, 1));
        out.differ_in_lanes +=
            lanes_that_differ(a, b, [](const auto& p, const auto& q) { return omnimorph::atan2(p, q); });
        out.differ_in_lanes += lanes_that_differ(a, b, [](const auto& p, const auto&) { return omnimorph::acos(p); });
        out.differ_in_lanes +=
            lanes_that_differ(a, b, [](const auto& p, const auto& q) { return omnimorph::exp(p * q); });
        out.differ_in_lanes +=
            lanes_that_differ(a, b, [](const auto& p, const auto&) { return omnimorph::log(p * p); });
    }
    return out;
}

template <class S, int Lanes> bool is_well(const char* name) {
    const Largest<S> e = largest_errors<S, Lanes>();
    std::printf(
        "%s: units in the last place: exponential %.2f, logarithm %.2f, arc tangent %.2f, arc cosine %.2f; %d lanes "
        "differ\n",
        name, e.exponential, e.logarithm, e.tangent, e.cosine, e.differ_in_lanes);
    return std::max({e.exponential, e.logarithm, e.tangent, e.cosine}) < allowed && e.differ_in_lanes == 0;
}

bool edges_are_well() {
    const double nothing = std::nan(""), pi = 3.14159265358979323846;
    return omnimorph::exp(0.0) == 1 && omnimorph::exp(-1e6) == 0 && omnimorph::log(1.0) == 0 &&
           omnimorph::atan2(0.0, 0.0) == 0 && omnimorph::atan2(0.0, 2.0) == 0 && omnimorph::atan2(0.0, -2.0) == pi &&
           omnimorph::atan2(3.0, 0.0) == pi / 2 && omnimorph::atan2(-3.0, 0.0) == -pi / 2 &&
           omnimorph::acos(1.0) == 0 && omnimorph::acos(-1.0) == pi && omnimorph::acos(7.0) == 0 &&
           !(omnimorph::atan2(nothing, 1.0) == 0) && !(omnimorph::exp(nothing) == 0) &&
           omnimorph::atan2(1.0, 1.0) == pi / 4;
}

}  // namespace

int main() {
    const bool in_double = is_well<double, 4>("double"), in_single = is_well<float, 8>("float");
    return in_double && in_single && edges_are_well() ? EXIT_SUCCESS : EXIT_FAILURE;
}
