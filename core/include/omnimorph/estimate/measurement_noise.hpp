// What the controller is told of the motion is not the motion.
#pragma once

#include "../math/random.hpp"
#include "../math/so3.hpp"
#include "../model/motion.hpp"

namespace omnimorph {

/// Gaussian noise on position, velocity, attitude (R exp([n]x)) and body rate, drawn once a control step; white, or passed
/// through a first-order low-pass filter as the vehicle's state estimator does, n_f <- n_f + gain (n - n_f).
template <class T> struct MeasurementNoise {
    bool active = false;
    Vec<T, 4> deviation{};    // 1 sigma: m, m/s, rad, rad/s
    Vec<T, 4> filter_gain{};  // 1 - e^(-period cutoff), 1 for white noise

    MeasurementNoise() = default;
    template <class S> explicit MeasurementNoise(const MeasurementNoise<S>& o)
        : active(o.active), deviation(cast<T>(o.deviation)), filter_gain(cast<T>(o.filter_gain)) {}

    /// The filters' outputs, and the first control step whose noise they have not had.
    struct State {
        T filtered[12];
        std::uint32_t next_step;
    };
    static State at_rest() {
        State s;
        for (T& value : s.filtered) value = T(0);
        s.next_step = 0;
        return s;
    }

    /// The motion as it is measured in a control step; measuring again, or not in every step, changes nothing later.
    /// `first` is the key of lane 0; the lanes are flights that follow one another.
    Motion<T> measure(const Motion<T>& truth, NoiseKey first, std::uint32_t step, State& memory) const {
        if (!active) return truth;
        for (; memory.next_step <= step; ++memory.next_step) draw(first, memory);
        const auto part = [&](int kind) {
            return Vec3<T>{{memory.filtered[3 * kind], memory.filtered[3 * kind + 1], memory.filtered[3 * kind + 2]}};
        };
        return {truth.p + part(0), truth.v + part(1), truth.R * exp_so3(part(2)), truth.w + part(3)};
    }

  private:
    /// Pass the noise of the next step through the filters.
    void draw(NoiseKey first, State& memory) const {
        for (int pair = 0; pair < 6; ++pair) {
            const std::array<T, 2> normal = standard_normal_pair<T>(first, memory.next_step, static_cast<std::uint32_t>(pair));
            for (int k = 0; k < 2; ++k) {
                const int c = 2 * pair + k, kind = c / 3;
                memory.filtered[c] += filter_gain[kind] * (deviation[kind] * normal[k] - memory.filtered[c]);
            }
        }
    }
};

}  // namespace omnimorph
