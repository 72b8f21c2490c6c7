// Noise that depends only on (seed, flight, step): a counter-based generator, the same wherever and beside whatever it
// runs.
#pragma once

#include <array>
#include <cstdint>

#include "elementary.hpp"

namespace omnimorph {

/// Philox 4x32, ten rounds (J. K. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
OMNIMORPH_FN std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                                 std::array<std::uint32_t, 2> key) {
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t x = std::uint64_t{0xD2511F53u} * counter[0], y = std::uint64_t{0xCD9E8D57u} * counter[2];
        counter = {static_cast<std::uint32_t>(y >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(y),
                   static_cast<std::uint32_t>(x >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(x)};
        key[0] += 0x9E3779B9u;
        key[1] += 0xBB67AE85u;
    }
    return counter;
}

/// Which flight the noise belongs to.
struct NoiseKey {
    std::uint64_t seed;
    std::uint32_t flight;
};

/// 53 bits as a number in (0, 1).
OMNIMORPH_FN double uniform(std::uint32_t high, std::uint32_t low) {
    const std::uint64_t joined = (std::uint64_t{high} << 32 | low) >> 11;
    return (static_cast<double>(joined) + 0.5) * 0x1p-53;
}

/// Two independent standard normal numbers: pair `pair` of step `step` (Box and Muller). The lanes of T are flights
/// that follow one another, from `first` on.
template <class T = double>
OMNIMORPH_FN std::array<T, 2> standard_normal_pair(NoiseKey first, std::uint32_t step, std::uint32_t pair) {
    T u, v;
    for (int l = 0; l < lane_count<T>; ++l) {
        const auto bits =
            philox({step, pair, first.flight + std::uint32_t(l), 0u},
                   {static_cast<std::uint32_t>(first.seed), static_cast<std::uint32_t>(first.seed >> 32)});
        set_lane(u, l, Scalar<T>(uniform(bits[0], bits[1])));
        set_lane(v, l, Scalar<T>(uniform(bits[2], bits[3])));
    }
    const T radius = sqrt(T(-2) * log(u));
    T sine, cosine;
    sincos(T(6.283185307179586) * v, sine, cosine);
    return {radius * cosine, radius * sine};
}

}  // namespace omnimorph
