// Sensors: the measurement of the motion, with noise.
#pragma once

#include "../math/random.hpp"
#include "../math/so3.hpp"
#include "../model/motion.hpp"

namespace omnimorph {

/// White Gaussian noise on position, velocity, attitude (R exp([n]x)) and body rate, drawn once a control step.
template <class T> struct MeasurementNoise {
    static constexpr const char* name = "measurement-noise";
    bool active = false;
    Vec<T, 4> deviation{};  // 1 sigma: m, m/s, rad, rad/s

    static constexpr auto fields() {
        return std::make_tuple(derived("active", &MeasurementNoise::active),
                               field("deviation", &MeasurementNoise::deviation));
    }
};

/// Pose and rates as they are read: the motion with an error on it, three numbers each for p, v, R and w. The two are
/// kept apart, because the low-pass filters that estimate the motion are taken to follow it without lag.
template <class T> struct Measurement {
    Motion<T> motion;
    Vec<T, 12> error;
    bool has_error;
    std::uint32_t control_step;
};

/// What the sensors read in a control step; the same, however often it is asked for. `first` is the key of lane 0; the
/// lanes are flights that follow one another.
template <class T>
OMNIMORPH_FN Measurement<T> sense(const MeasurementNoise<T>& noise, const Motion<T>& motion, NoiseKey first,
                                  std::uint32_t control_step) {
    Measurement<T> measured;
    measured.motion = motion;
    measured.has_error = noise.active;
    measured.control_step = control_step;
    if (!noise.active) return measured;
    for (int pair = 0; pair < 6; ++pair) {
        const auto normal = standard_normal_pair<T>(first, control_step, static_cast<std::uint32_t>(pair));
        for (int k = 0; k < 2; ++k) {
            const int c = 2 * pair + k;
            measured.error[c] = noise.deviation[c / 3] * normal[k];
        }
    }
    return measured;
}

}  // namespace omnimorph
