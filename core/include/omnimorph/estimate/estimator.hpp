// The estimator: from what the sensors read to what the controller takes for true. Each is a record with a state of its
// own; a new one is a line here.
#pragma once

#include "low_pass.hpp"

namespace omnimorph {

template <class T> using Estimator = std::variant<LowPass<T>>;

/// What the controller knows of the vehicle.
template <class T> struct Estimate {
    Motion<T> motion;
};

namespace estimator {

template <class Choice> struct StatesOf;
template <class... Each> struct StatesOf<std::variant<Each...>> {
    using Type = Records<typename Each::State...>;
};

}  // namespace estimator

/// The states of all kinds of estimators, and the first control step whose measurement they have not had.
template <class T> struct EstimatorState {
    typename estimator::StatesOf<Estimator<T>>::Type states;
    std::uint32_t next_step = 0;

    static constexpr auto fields() {
        return field_list(field("states", &EstimatorState::states), field("next_step", &EstimatorState::next_step));
    }
};

/// Whether there is anything to estimate: not for an estimator that follows the motion itself, where no sensor errs.
template <class T> OMNIMORPH_FN bool is_needed(const Estimator<T>& settings, bool has_error) {
    return has_error ||
           !std::visit([](const auto& one) { return std::decay_t<decltype(one)>::follows_motion; }, settings);
}

/// The estimate after a measurement; one that was had already changes nothing.
template <class T>
OMNIMORPH_FN Estimate<T> estimate(const Estimator<T>& settings, const Measurement<T>& measured,
                                  EstimatorState<T>& state) {
    if (!is_needed(settings, measured.has_error)) return {measured.motion};
    return std::visit(
        [&](const auto& estimator) -> Estimate<T> {
            auto& own = get<typename std::decay_t<decltype(estimator)>::State>(state.states);
            if (measured.control_step >= state.next_step) {
                estimator.update(measured, own);
                state.next_step = measured.control_step + 1;
            }
            return {estimator.motion(measured, own)};
        },
        settings);
}

/// The estimate in a control step that someone asks for who may have left some out, or asks again: the measurement of
/// each step is taken in once.
template <class T>
OMNIMORPH_FN Estimate<T> estimate_in_step(const Sensors<T>& sensors, const Estimator<T>& settings,
                                          const Motion<T>& motion, NoiseKey first, std::uint32_t control_step,
                                          EstimatorState<T>& state) {
    if (is_needed(settings, has_error(sensors)))
        while (state.next_step < control_step)
            estimate(settings, sense(sensors, motion, first, state.next_step), state);
    return estimate(settings, sense(sensors, motion, first, control_step), state);
}

}  // namespace omnimorph
