// Tilt servos: lag and rate limit.
#pragma once

#include "actuators.hpp"

namespace omnimorph {

/// First-order lag: covers the share 1 - e^(-h/tau) of what is left in a step.
template <class T> struct ServoLag {
    static constexpr const char* name = "servo-lag";
    bool active = false;
    PerServo<T> time_constant{};  // tau, s
    PerServo<T> keep{};           // e^(-h/tau) over the integrator's actuator step

    static constexpr auto fields() {
        return field_list(derived("active", &ServoLag::active), field("time_constant", &ServoLag::time_constant),
                          derived("keep", &ServoLag::keep));
    }

    OMNIMORPH_FN T travel(int j, const T& way_left, ActuatorStep step) const {
        return step.passes() ? (T(1) - keep[j]) * way_left : T(0);
    }
};

/// Set what follows from the other fields, for m servos and the integrator's actuator step h.
OMNIMORPH_FN void derive(ServoLag<double>& lag, int, int m, double h) {
    for (int j = 0; j < m; ++j) lag.keep[j] = decay(h, lag.time_constant[j]);
}

/// Travels at most the rate limit times the step.
template <class T> struct ServoRateLimit {
    static constexpr const char* name = "servo-rate-limit";
    bool active = false;
    PerServo<T> rate{};  // rad/s
    PerServo<T> most{};  // rad in the integrator's actuator step

    static constexpr auto fields() {
        return field_list(derived("active", &ServoRateLimit::active), field("rate", &ServoRateLimit::rate),
                          derived("most", &ServoRateLimit::most));
    }

    OMNIMORPH_FN T travel(int j, const T& wanted, ActuatorStep step) const {
        return step.passes() ? clamp(wanted, -most[j], most[j]) : T(0);
    }
};

OMNIMORPH_FN void derive(ServoRateLimit<double>& limit, int, int m, double h) {
    for (int j = 0; j < m; ++j) limit.most[j] = limit.rate[j] * h;
}

}  // namespace omnimorph
