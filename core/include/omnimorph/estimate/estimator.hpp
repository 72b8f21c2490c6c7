// The estimator: from a measurement to the estimate that the controller uses.
#pragma once

#include "sensors.hpp"

namespace omnimorph {

/// What the controller knows of the vehicle.
template <class T> struct Estimate {
    Motion<T> motion;
};

/// First-order low-pass filters, n_f <- n_f + gain (n - n_f), as a vehicle's state estimator has them; they follow the
/// motion itself without lag, so that only the errors of the sensors pass through them. Without a cutoff an error
/// passes as it is.
template <class T> struct LowPass {
    Vec<T, 4> cutoff{};  // rad/s, of position, velocity, attitude and body rate; 0 for none
    Vec<T, 4> gain{};    // 1 - e^(-period cutoff)

    static constexpr auto fields() {
        return std::make_tuple(field("cutoff", &LowPass::cutoff), derived("gain", &LowPass::gain));
    }
};

OMNIMORPH_FN void derive(LowPass<double>& filter, double control_period) {
    for (int k = 0; k < 4; ++k)
        filter.gain[k] = filter.cutoff[k] > 0 ? 1.0 - std::exp(-control_period * filter.cutoff[k]) : 1.0;
}

/// The filters' outputs, and the first control step whose errors they have not had.
template <class T> struct LowPassState {
    Vec<T, 12> filtered = Vec<T, 12>::zero();
    std::uint32_t next_step = 0;

    static constexpr auto fields() {
        return std::make_tuple(field("filtered", &LowPassState::filtered),
                               field("next_step", &LowPassState::next_step));
    }
};

/// The motion with an error on it: three numbers each for p, v, R exp([n]x) and w.
template <class T> OMNIMORPH_FN Motion<T> with_error(const Motion<T>& motion, const Vec<T, 12>& error) {
    const auto part = [&](int kind) { return Vec3<T>{{error[3 * kind], error[3 * kind + 1], error[3 * kind + 2]}}; };
    return {motion.p + part(0), motion.v + part(1), motion.R * exp_so3(part(2)), motion.w + part(3)};
}

/// The estimate after a measurement; one that the filters have had already does not change them.
template <class T>
OMNIMORPH_FN Estimate<T> estimate(const LowPass<T>& filter, const Measurement<T>& measured, LowPassState<T>& state) {
    if (!measured.has_error) return {measured.motion};
    if (measured.control_step >= state.next_step) {
        for (int c = 0; c < 12; ++c) state.filtered[c] += filter.gain[c / 3] * (measured.error[c] - state.filtered[c]);
        state.next_step = measured.control_step + 1;
    }
    return {with_error(measured.motion, state.filtered)};
}

/// The estimate in a control step, for a caller that may skip steps or ask twice for one: the errors of each step pass
/// through the filters once.
template <class T>
OMNIMORPH_FN Estimate<T> estimate_in_step(const MeasurementNoise<T>& sensors, const LowPass<T>& filter,
                                          const Motion<T>& motion, NoiseKey first, std::uint32_t control_step,
                                          LowPassState<T>& state) {
    if (sensors.active)
        while (state.next_step < control_step) estimate(filter, sense(sensors, motion, first, state.next_step), state);
    return estimate(filter, sense(sensors, motion, first, control_step), state);
}

}  // namespace omnimorph
