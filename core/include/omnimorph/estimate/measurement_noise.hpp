// Noise on what is measured.
#pragma once

#include "../math/random.hpp"
#include "../math/records.hpp"
#include "../math/so3.hpp"
#include "../model/motion.hpp"

namespace omnimorph {

/// White Gaussian noise on position, velocity, attitude (R exp([n]x)) and body rate, drawn once a control step.
template <class T> struct MeasurementNoise {
    static constexpr const char* name = "measurement-noise";
    bool active = false;
    Vec<T, 4> deviation{};  // 1 sigma: m, m/s, rad, rad/s

    static constexpr auto fields() {
        return field_list(derived("active", &MeasurementNoise::active),
                          field("deviation", &MeasurementNoise::deviation));
    }

    OMNIMORPH_FN Vec<T, 12> error(const Motion<T>&, NoiseKey first, std::uint32_t control_step) const {
        Vec<T, 12> error;
        for (int pair = 0; pair < 6; ++pair) {
            const auto normal = standard_normal_pair<T>(first, control_step, static_cast<std::uint32_t>(pair));
            for (int k = 0; k < 2; ++k) error[2 * pair + k] = deviation[(2 * pair + k) / 3] * normal[k];
        }
        return error;
    }
};

}  // namespace omnimorph
