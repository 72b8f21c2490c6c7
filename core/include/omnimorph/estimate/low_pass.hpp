// The estimator that a vehicle's filters are.
#pragma once

#include "sensors.hpp"

namespace omnimorph {

/// First-order low-pass filters, n_f <- n_f + gain (n - n_f), as a vehicle's state estimator has them; they follow the
/// motion itself without lag, so that only the errors of the sensors pass through them. Without a cutoff an error
/// passes as it is.
template <class T> struct LowPass {
    static constexpr const char* name = "low-pass";
    static constexpr bool follows_motion = true;  // it gives the motion itself where the sensors have no error
    Vec<T, 4> cutoff{};                           // rad/s, of position, velocity, attitude and body rate; 0 for none
    Vec<T, 4> gain{};                             // 1 - e^(-period cutoff)

    static constexpr auto fields() {
        return field_list(field("cutoff", &LowPass::cutoff), derived("gain", &LowPass::gain));
    }

    /// The filters' outputs.
    struct State {
        Vec<T, 12> filtered = Vec<T, 12>::zero();

        static constexpr auto fields() { return field_list(field("filtered", &State::filtered)); }
    };

    /// Take in the measurement of the next control step.
    OMNIMORPH_FN void update(const Measurement<T>& measured, State& state) const {
        for (int c = 0; c < 12; ++c) state.filtered[c] += gain[c / 3] * (measured.error[c] - state.filtered[c]);
    }
    OMNIMORPH_FN Motion<T> motion(const Measurement<T>& measured, const State& state) const {
        return with_error(measured.motion, state.filtered);
    }
};

OMNIMORPH_FN void derive(LowPass<double>& filters, double control_period) {
    for (int k = 0; k < 4; ++k)
        filters.gain[k] = filters.cutoff[k] > 0 ? 1.0 - std::exp(-control_period * filters.cutoff[k]) : 1.0;
}

}  // namespace omnimorph
